// The least that `tp-jax record` can read: t [s], phi1, phi2 [rad] on a line, 250 times a second.
// Straight-line calibration of two bridges, as in the paper; the drive is not commanded.
// The clock begins anew after 71.6 minutes; the recorder counts on.
const float OFFSET1 = 512.0, GAIN1 = 810.0, OFFSET2 = 512.0, GAIN2 = 810.0;  // counts, counts/rad
void setup() { Serial.begin(460800); }
void loop() {
  static uint32_t next = micros();
  while ((int32_t)(micros() - next) < 0) {}
  Serial.print(next * 1e-6, 4); Serial.print(' ');
  Serial.print((analogRead(A0) - OFFSET1) / GAIN1, 5); Serial.print(' ');
  Serial.println((analogRead(A1) - OFFSET2) / GAIN2, 5);
  next += 4000;
}
