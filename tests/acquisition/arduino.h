// Just enough of the Arduino core to run the reference firmware on a computer: Serial is the
// program's standard input and output, the bridges see a known motion.
#pragma once
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

const int HIGH = 1, LOW = 0, OUTPUT = 1, A0 = 100, A1 = 101, A2 = 102, A3 = 103;
static uint32_t steps_made = 0;

static double now() {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}
#ifndef POWERED_FOR
#define POWERED_FOR 4294000000.0  // microseconds: 32 bits, as on a board, are about to wrap
#endif
inline uint32_t micros() {
  static double begin = now();
  return (uint32_t)(uint64_t)((now() - begin) * 1e6 + POWERED_FOR);
}
inline void pinMode(int, int) {}
inline void digitalWrite(int pin, int level) { if (pin == 2 && level) steps_made++; }
inline void analogReadResolution(int) {}
inline int analogRead(int pin) {
  double t = now(), angle = pin < A2 ? 0.4 * sin(9.0 * t) : 0.3 * sin(4.0 * t);
#ifdef TEXT
  return (int)lround(512.0 + 810.0 * (pin == A0 ? 0.4 * sin(9.0 * t) : 0.3 * sin(4.0 * t)));
#endif
  double part = (pin - A0) % 2 ? cos(2.0 * angle) : sin(2.0 * angle);
  return (int)lround(4095.0 * (1.65 + 1.3 * part) / 3.3);
}

struct SerialPort {
  uint8_t ahead;
  bool has = false;
  void begin(uint32_t) { fcntl(0, F_SETFL, fcntl(0, F_GETFL) | O_NONBLOCK); }
  int available() {
    if (has) return 1;
    has = ::read(0, &ahead, 1) == 1;
    if (!has) usleep(50);
    return has;
  }
  int read() { has = false; return ahead; }
  void write(const uint8_t* data, int n) {
    while (n > 0) {
      int done = ::write(1, data, n);
      if (done > 0) { data += done; n -= done; } else usleep(100);
    }
  }
  void text(const char* s) { write((const uint8_t*)s, strlen(s)); }
  void print(const char* s) { text(s); }
  void print(char c) { write((const uint8_t*)&c, 1); }
  void print(double x, int digits) { char s[40]; snprintf(s, sizeof s, "%.*f", digits, x); text(s); }
  void println(double x, int digits) { print(x, digits); text("\r\n"); }
};
static SerialPort Serial;

void setup();
void loop();
int main() {
  setup();
  while (getppid() != 1) loop();
}
