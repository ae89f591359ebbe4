// The least that `tp-jax record` can read: t [s], phi1, phi2 [rad] on a line, 250 times a second,
// by the straight-line calibration of two bridges; the clock may begin anew after 71.6 minutes.
const float OFFSET1 = 512.0, GAIN1 = 810.0, OFFSET2 = 512.0, GAIN2 = 810.0;  // counts, counts/rad
void setup() { Serial.begin(460800); }
void loop() {
  static uint32_t next = micros();
  while ((int32_t)(micros() - next) < 0) {}
  const unsigned long now = micros();  // of the reading: lines that wait make it late
  const float a = analogRead(A0), b = analogRead(A1);
  char t[16]; sprintf(t, "%lu.%06lu ", now / 1000000, now % 1000000); Serial.print(t);
  Serial.print((a - OFFSET1) / GAIN1, 5); Serial.print(' ');
  Serial.println((b - OFFSET2) / GAIN2, 5);
  next += 4000;
}
