// Reference firmware of a torsion pendulum rig, protocol version 1 (tp_jax/acquisition/protocol.py).
//
// Two HMC1512 magnetoresistive sensors (two bridges each), amplified, at four analogue inputs; a
// step/direction driver turns the motor, whose crank moves the spring's end: f = A sin(omega t).
// For any board with the Arduino core, micros(), and numbers in little-endian order (AVR, ARM,
// ESP32 all are). The host's commands and the samples are frames: body, CRC-32, COBS, zero byte.

#include <string.h>

// This rig -------------------------------------------------------------------------------------

const uint32_t BAUD = 460800;
const uint32_t RATE_MHZ = 1000000;      // samples per 1000 s: 1 kHz; what the board can do
const uint32_t REFERENCE_UV = 3300000;  // full scale of the converter
const uint8_t ADC_BITS = 12;            // 10 on an Uno, 16 on a FRDM-KL25Z
const uint8_t WIRED = 0b1111;           // sine 1, cosine 1, sine 2, cosine 2
const int PINS[4] = {A0, A1, A2, A3};
const int STEP_PIN = 2, DIRECTION_PIN = 3, ENABLE_PIN = 4;
const uint32_t STEPS = 1600;            // steps of a turn of the crank: 200 at 1.8 degrees, times 8
const int32_t AMPLITUDE_URAD = 180000;  // that the crank is built for; 0: not known
const char NAME[] = "torsion pendulum, rig_frames 1";

// The calibration, where there is one: offset [V], gain [V/rad], cosine offset, cosine gain, zero
// [rad], then their standard errors. Set CALIBRATED and write down what your calibration run gave.
const bool CALIBRATED = false;
const float CALIBRATION[2][10] = {
  {1.65, 2.6, 1.65, 2.6, 0.0, 0.05, 0.2, 0.05, 0.2, 0.0},
  {1.65, 2.6, 1.65, 2.6, 0.0, 0.05, 0.2, 0.05, 0.2, 0.0},
};

// Frames ---------------------------------------------------------------------------------------

const uint8_t MOST = 128;  // bytes of a body with its CRC
uint8_t body[MOST];
uint8_t length = 0;

void put(const void* data, uint8_t n) { memcpy(body + length, data, n); length += n; }
void put8(uint8_t x) { put(&x, 1); }
void put32(uint32_t x) { put(&x, 4); }

uint32_t crc32(const uint8_t* data, uint8_t n) {
  uint32_t crc = 0xFFFFFFFF;
  while (n--) {
    crc ^= *data++;
    for (uint8_t i = 0; i < 8; i++) crc = crc & 1 ? (crc >> 1) ^ 0xEDB88320 : crc >> 1;
  }
  return ~crc;
}

void sendFrame() {
  put32(crc32(body, length));
  uint8_t wire[MOST + 2], code = 0, out = 1;  // COBS: wire[code] counts the bytes up to a zero
  for (uint8_t i = 0; i < length; i++) {
    if (body[i]) { wire[out++] = body[i]; continue; }
    wire[code] = out - code;
    code = out++;
  }
  wire[code] = out - code;
  wire[out++] = 0;
  Serial.write(wire, out);
  length = 0;
}

// Undoes COBS in place and checks the CRC; the length of the body without it, 0 if damaged.
uint8_t decodeFrame(uint8_t* wire, uint8_t n) {
  uint8_t out = 0, i = 0;
  while (i < n) {
    uint8_t code = wire[i++];
    if (code == 0 || i + code - 1 > n) return 0;
    for (uint8_t j = 1; j < code; j++) wire[out++] = wire[i++];
    if (i < n) wire[out++] = 0;
  }
  if (out < 5) return 0;
  uint32_t sent;
  memcpy(&sent, wire + out - 4, 4);
  return crc32(wire, out - 4) == sent ? out - 4 : 0;
}

// The run --------------------------------------------------------------------------------------

uint32_t boot = 0, begin_us = 0, sequence = 0;
uint32_t omega_urad = 0;      // commanded
uint32_t step_begin_us = 0;   // when the step in progress began
uint32_t step_period_ns = 0;  // 0: the motor stands
uint32_t step_carry_ns = 0;
uint8_t run = 0;
bool running = false;

void startMotor() {
  // a turn of the crank is a period of the drive: STEPS steps in 2 pi / omega
  step_period_ns = omega_urad ? (uint32_t)(6.283185307e15 / omega_urad / STEPS) : 0;
  step_begin_us = begin_us;
  step_carry_ns = 0;
  digitalWrite(ENABLE_PIN, omega_urad ? LOW : HIGH);
}

void stopMotor() {
  step_period_ns = 0;
  digitalWrite(ENABLE_PIN, HIGH);
}

// The period in whole nanoseconds is what the drive really does: that is what the host is told.
uint32_t realisedOmega() {
  uint32_t period = omega_urad ? (uint32_t)(6.283185307e15 / omega_urad / STEPS) : 0;
  return period ? (uint32_t)(6.283185307e15 / STEPS / period + 0.5) : 0;
}

void turnMotor() {
  if (!step_period_ns) return;
  uint32_t whole = step_period_ns / 1000;
  if (micros() - step_begin_us < whole) return;
  digitalWrite(STEP_PIN, HIGH);
  step_begin_us += whole;
  step_carry_ns += step_period_ns % 1000;
  if (step_carry_ns >= 1000) { step_carry_ns -= 1000; step_begin_us++; }
  digitalWrite(STEP_PIN, LOW);
}

void beginRun(uint32_t omega) {
  omega_urad = omega;
  run++;
  sequence = 0;
  begin_us = micros();
  running = true;
  startMotor();
}

void sendSample(uint32_t due) {
  put8(1); put8(run); put32(sequence); put32(due);
  for (uint8_t i = 0; i < 4; i++) {
    uint16_t counts = 0;
    // bits repeated downwards, so that full scale is 65535 whatever the converter has
    if (WIRED >> i & 1) {
      uint16_t raw = analogRead(PINS[i]) << (16 - ADC_BITS);
      counts = raw | raw >> ADC_BITS;
    }
    put(&counts, 2);
  }
  sendFrame();
}

// What the host says ---------------------------------------------------------------------------

uint8_t heard[64], heard_length = 0;
uint8_t last_command = 0, last_tag = 0;
uint8_t last_ack[16];

void introduce(uint8_t tag) {
  put8(2); put8(tag); put8(1); put8(WIRED);
  put8((running ? 1 : 0) | 2 | (CALIBRATED ? 4 : 0));
  put8(run); put8(ADC_BITS); put8(0);
  put32(boot); put32(RATE_MHZ); put32(REFERENCE_UV); put32(AMPLITUDE_URAD);
  put(NAME, sizeof NAME - 1);
  sendFrame();
  for (uint8_t sensor = 0; CALIBRATED && sensor < 2; sensor++) {
    put8(3); put8(tag); put8(sensor + 1); put8(WIRED >> (2 * sensor + 1) & 1 ? 2 : 1);
    put(CALIBRATION[sensor], sizeof CALIBRATION[sensor]);
    sendFrame();
  }
}

void obey(const uint8_t* frame, uint8_t n) {
  uint8_t command = frame[0], tag = frame[1], status = 0;
  uint32_t number = 0, value = 0;
  if (n >= 6) memcpy(&number, frame + 2, 4);
  if (command == 0x81) { introduce(tag); return; }
  if (command == last_command && tag == last_tag) {  // said again: the answer was lost
    put(last_ack, sizeof last_ack);
    sendFrame();
    return;
  }
  switch (command) {
    case 0x82: {  // DRIVE; the amplitude is the crank's: 0 leaves it, another one cannot be done
      int32_t amplitude = 0;
      if (n >= 10) memcpy(&amplitude, frame + 6, 4);
      bool other = amplitude && AMPLITUDE_URAD && amplitude != AMPLITUDE_URAD;
      if (n < 10 || other) status = 2;
      else { omega_urad = number; value = realisedOmega(); }
      break;
    }
    case 0x83: beginRun(omega_urad); break;                              // START
    case 0x84: running = false; stopMotor(); break;                      // STOP
    case 0x85: value = number; beginRun(0); break;                       // RELEASE, by hand
    default: status = 1;
  }
  put8(4); put8(tag); put8(command); put8(status); put8(run);
  put8(0); put8(0); put8(0);
  put32(begin_us); put32(value);
  memcpy(last_ack, body, sizeof last_ack);
  last_command = command;
  last_tag = tag;
  sendFrame();
}

void listen() {
  while (Serial.available()) {
    uint8_t c = Serial.read();
    if (c) {
      if (heard_length < sizeof heard) heard[heard_length++] = c;
      continue;
    }
    uint8_t n = heard_length ? decodeFrame(heard, heard_length) : 0;
    heard_length = 0;
    if (n >= 2) obey(heard, n);
  }
}

void setup() {
  pinMode(STEP_PIN, OUTPUT);
  pinMode(DIRECTION_PIN, OUTPUT);
  pinMode(ENABLE_PIN, OUTPUT);
  digitalWrite(ENABLE_PIN, HIGH);
#if defined(__arm__) || defined(ESP32)
  analogReadResolution(ADC_BITS);
#endif
  // a number that differs after every power-up: the noise of the converter, and the time
  for (uint8_t i = 0; i < 32; i++) boot = (boot << 1 | boot >> 31) ^ analogRead(PINS[i % 4]) ^ micros();
  Serial.begin(BAUD);
}

void loop() {
  turnMotor();
  if (running) {
    // the n-th sample is due at n * 1e9 / RATE_MHZ microseconds; whole ones at the usual rates
    uint32_t due = begin_us + (uint32_t)((uint64_t)sequence * 1000000000ULL / RATE_MHZ);
    if ((int32_t)(micros() - due) >= 0) { sendSample(due); sequence++; }
  }
  listen();
}
