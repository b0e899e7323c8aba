// A pressure board on an Arduino Mega or Uno: two channels, each with a sensor of the MPX5100 kind, a normally closed valve
// from the tank and a normally open one to the atmosphere, so that it vents without power. One pump with a pressure switch.

#include <avr/wdt.h>
#include <sinew_board_link.h>

// --- Wiring ---

const uint8_t kAddress = 1;
const uint32_t kBaud = 500000;  // exact with a clock of 16 MHz, unlike 115200
const uint8_t kChannels = 2;
const uint8_t kSensorPins[kChannels] = {A0, A1};
const uint8_t kFillPins[kChannels] = {5, 6};      // MOSFET of the valve from the tank; these pins can do PWM
const uint8_t kExhaustPins[kChannels] = {9, 10};  // MOSFET of the valve to the atmosphere; likewise
const uint8_t kPumpPin = 7;
const uint8_t kTankSwitchPin = 8;  // closes to ground when the tank has pressure
const uint8_t kStopPin = 2;        // emergency stop, opens from ground when pressed
const uint8_t kSupplyPin = A2;     // behind a divider of 22 kOhm and 10 kOhm
const uint8_t kTemperaturePin = A3;  // TMP36
const uint8_t kTransmitPin = 255;  // enables an RS-485 driver; 255: none

// --- Hardware ---

// MPX5100 data sheet, transfer function: Vout = VS (0.009 P + 0.04), P in kPa. The converter measures against the same VS.
int32_t readPressure(void*, uint8_t channel) {
  const int32_t counts = analogRead(kSensorPins[channel]);
  if (counts < 20 || counts > 1010) return 10000000;  // wire open or short
  const int32_t millionths = counts * 1000000 / 1023;
  return (millionths - 40000) / 9;
}

int32_t millivolts(uint8_t pin) {
  return (int32_t)analogRead(pin) * 5000 / 1023;
}

uint16_t readSupply(void*) {
  return (uint16_t)(millivolts(kSupplyPin) * 32 / 10);
}

// TMP36 data sheet: 500 mV at 0 degC, 10 mV a degree.
int16_t readTemperature(void*) {
  return (int16_t)(millivolts(kTemperaturePin) - 500);
}

int32_t readSource(void*) {
  return digitalRead(kTankSwitchPin) == LOW ? 2 : 0;
}

bool readStop(void*) {
  return digitalRead(kStopPin) == HIGH;
}

uint32_t readMillis(void*) {
  return millis();
}

void setValves(void*, uint8_t channel, sinew_path path, uint8_t duty) {
  const bool exhausts = path == SINEW_PATH_EXHAUST || path == SINEW_PATH_EVACUATE;
  analogWrite(kFillPins[channel], path == SINEW_PATH_FILL ? duty : 0);
  analogWrite(kExhaustPins[channel], exhausts ? 255 - duty : 255);
}

void setPump(void*, bool on) {
  digitalWrite(kPumpPin, on ? HIGH : LOW);
}

sinew_board_settings makeSettings() {
  sinew_board_settings s = {};
  s.identity.firmware_major = 1;
  s.identity.channels = kChannels;
  s.identity.serial_number = 1;
  s.identity.range_max = 100000;  // Pa; no vacuum
  s.hysteresis = 300;             // Pa, three steps of the converter
  s.proportional_band = 6000;     // Pa
  s.least_duty = 60;              // where these valves begin to open
  s.supply_min = 10500;           // mV
  s.supply_max = 14500;
  s.temperature_max = 600;  // 0.1 degC
  s.source_low = 1;         // the switch says 0 or 2
  s.source_high = 2;
  s.source_time = 20000;  // ms
  return s;
}

sinew_hardware makeHardware() {
  sinew_hardware h = {};
  h.millis = readMillis;
  h.pressure = readPressure;
  h.source_pressure = readSource;
  h.supply = readSupply;
  h.temperature = readTemperature;
  h.emergency_stop = readStop;
  h.set_valves = setValves;
  h.set_pump = setPump;
  return h;
}

// --- Board ---

sinew_board board;
sinew_serial_link serial_link;
uint8_t answer[SINEW_MAX_FRAME];

void send(size_t size) {
  if (kTransmitPin != 255) digitalWrite(kTransmitPin, HIGH);
  Serial.write(answer, size);
  if (kTransmitPin == 255) return;
  Serial.flush();
  digitalWrite(kTransmitPin, LOW);
}

void setup() {
  for (uint8_t i = 0; i < kChannels; ++i) {
    pinMode(kFillPins[i], OUTPUT);
    pinMode(kExhaustPins[i], OUTPUT);
  }
  pinMode(kPumpPin, OUTPUT);
  pinMode(kTankSwitchPin, INPUT_PULLUP);
  pinMode(kStopPin, INPUT_PULLUP);
  if (kTransmitPin != 255) pinMode(kTransmitPin, OUTPUT);
  Serial.begin(kBaud);
  const sinew_board_settings settings = makeSettings();
  const sinew_hardware hardware = makeHardware();
  sinew_board_start(&board, &settings, &hardware);
  sinew_serial_start(&serial_link, &board, kAddress);
  wdt_enable(WDTO_120MS);  // a program that hangs restarts, and so vents
}

void loop() {
  static uint32_t updated_at = 0;
  wdt_reset();
  while (Serial.available() > 0) {
    const size_t size = sinew_serial_take(&serial_link, (uint8_t)Serial.read(), answer);
    if (size > 0) send(size);
  }
  if (millis() - updated_at < 5) return;
  updated_at = millis();
  sinew_board_update(&board);
}
