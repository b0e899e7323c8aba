#include "sinew_board.h"

#include <string.h>

enum {
  MIN_TIMEOUT = 20,         /* ms */
  MAX_TIMEOUT = 5000,       /* ms */
  MAX_STEP = 100,           /* ms of ramp that one update may make up for */
  IMPLAUSIBLE_READINGS = 3, /* in a row until a sensor or the supply counts as bad */
  FULL_DUTY = 255
};
static const uint32_t kMaxRamp = 10000000ul; /* Pa/s; keeps ramp * MAX_STEP within 32 bits */

static uint8_t channel_count(const sinew_board* board) {
  return board->settings.identity.channels;
}

/* A twentieth of the range: tolerance of the sensors' ends and of the overpressure latch. */
static int32_t calc_margin(const sinew_board* board) {
  const sinew_identity* identity = &board->settings.identity;
  return (identity->range_max - identity->range_min) / 20;
}

static void set_path(sinew_board* board, uint8_t channel, sinew_path path, uint8_t duty) {
  board->channels[channel].path = path;
  board->hardware.set_valves(board->hardware.context, channel, path, duty);
}

static void set_pump(sinew_board* board, bool on) {
  board->pump = on;
  board->hardware.set_pump(board->hardware.context, on);
}

void sinew_board_start(sinew_board* board, const sinew_board_settings* settings, const sinew_hardware* hardware) {
  memset(board, 0, sizeof *board);
  board->settings = *settings;
  board->hardware = *hardware;
  if (board->settings.identity.channels > SINEW_MAX_CHANNELS) board->settings.identity.channels = SINEW_MAX_CHANNELS;
  board->started_at = board->updated_at = board->source_ok_at = hardware->millis(hardware->context);
  for (uint8_t i = 0; i < channel_count(board); ++i) {
    board->channels[i].pressure = hardware->pressure(hardware->context, i);
    set_path(board, i, SINEW_PATH_EXHAUST, FULL_DUTY);
  }
  set_pump(board, false);
}

/* --- Supervision --- */

static void raise_fault(sinew_board* board, uint8_t channel, uint8_t fault) {
  sinew_channel* c = &board->channels[channel];
  c->faults = (uint8_t)(c->faults | fault);
  c->mode = SINEW_VENT;
  if (fault == SINEW_FAULT_TIMEOUT && c->configuration.on_timeout == SINEW_SEAL) c->mode = SINEW_SEAL;
}

static void raise_everywhere(sinew_board* board, uint8_t fault) {
  for (uint8_t i = 0; i < channel_count(board); ++i) raise_fault(board, i, fault);
}

static bool any_regulates(const sinew_board* board) {
  for (uint8_t i = 0; i < channel_count(board); ++i)
    if (board->channels[i].mode == SINEW_REGULATE) return true;
  return false;
}

static bool supply_is_bad(const sinew_board* board) {
  const uint16_t supply = board->hardware.supply(board->hardware.context);
  return supply < board->settings.supply_min || supply > board->settings.supply_max;
}

static bool is_hot(const sinew_board* board) {
  return board->hardware.temperature(board->hardware.context) > board->settings.temperature_max;
}

static void supervise_board(sinew_board* board) {
  if (board->hardware.emergency_stop(board->hardware.context)) raise_everywhere(board, SINEW_FAULT_STOP);
  if (is_hot(board)) raise_everywhere(board, SINEW_FAULT_TEMPERATURE);
  board->supply_misses = supply_is_bad(board) ? (uint8_t)(board->supply_misses + 1) : 0;
  if (board->supply_misses < IMPLAUSIBLE_READINGS) return;
  board->supply_misses = IMPLAUSIBLE_READINGS;
  raise_everywhere(board, SINEW_FAULT_SUPPLY);
}

static void supervise_source(sinew_board* board, uint32_t now) {
  const sinew_board_settings* s = &board->settings;
  if (s->source_high == 0) return;
  const bool needed = any_regulates(board);
  const int32_t pressure = board->hardware.source_pressure(board->hardware.context);
  if (!needed || pressure >= s->source_high)
    set_pump(board, false);
  else if (pressure < s->source_low)
    set_pump(board, true);
  if (!needed || pressure >= s->source_low) board->source_ok_at = now;
  if (now - board->source_ok_at > s->source_time) raise_everywhere(board, SINEW_FAULT_SOURCE);
}

static bool is_plausible(const sinew_board* board, int32_t pressure) {
  const sinew_identity* identity = &board->settings.identity;
  const int32_t margin = calc_margin(board);
  return pressure >= identity->range_min - margin && pressure <= identity->range_max + margin;
}

static void supervise_channel(sinew_board* board, uint8_t channel, uint32_t now) {
  sinew_channel* c = &board->channels[channel];
  const int32_t measured = board->hardware.pressure(board->hardware.context, channel);
  if (is_plausible(board, measured)) {
    c->implausible = 0;
    c->pressure = measured;
  } else if (++c->implausible >= IMPLAUSIBLE_READINGS) {
    c->implausible = IMPLAUSIBLE_READINGS;
    c->pressure = measured;
    raise_fault(board, channel, SINEW_FAULT_SENSOR);
  }
  if (c->mode == SINEW_VENT) return;
  if (c->pressure > c->configuration.maximum + calc_margin(board))
    raise_fault(board, channel, SINEW_FAULT_OVERPRESSURE);
  if ((c->faults & SINEW_FAULT_TIMEOUT) == 0 && now - c->commanded_at > board->timeout)
    raise_fault(board, channel, SINEW_FAULT_TIMEOUT);
}

/* --- Regulation --- */

static int32_t limit32(int32_t x, int32_t low, int32_t high) {
  return x < low ? low : x > high ? high : x;
}

/* Moves the reference by at most ramp * dt, and never farther from the measurement than the valves can use: what was
 * held back by a kinked hose does not shoot in later. */
static void update_reference(sinew_board* board, sinew_channel* c, uint32_t dt) {
  const uint32_t ramp = c->set_point.ramp < c->configuration.ramp ? c->set_point.ramp : c->configuration.ramp;
  const uint32_t thousandths = ramp * dt + c->ramp_rest;
  const int32_t step = (int32_t)(thousandths / 1000u);
  const int32_t lead = 2 * board->settings.hysteresis + board->settings.proportional_band;
  c->ramp_rest = c->reference == c->set_point.pressure ? 0 : thousandths % 1000u;
  c->reference = limit32(c->reference, c->pressure - lead, c->pressure + lead);
  c->reference = limit32(c->set_point.pressure, c->reference - step, c->reference + step);
}

static uint8_t calc_duty(const sinew_board_settings* s, int32_t off) {
  const int32_t beyond = off - s->hysteresis;
  if (beyond >= s->proportional_band) return FULL_DUTY;
  return (uint8_t)(s->least_duty + beyond * (FULL_DUTY - s->least_duty) / s->proportional_band);
}

/* Which valve brings the pressure up or down: the atmosphere does what it can before the pump or the vacuum. */
static sinew_path choose_path(const sinew_board* board, const sinew_channel* c) {
  const int32_t near = 2 * board->settings.hysteresis;
  if (c->reference > c->pressure)
    return c->reference <= 0 && c->pressure < -near ? SINEW_PATH_EXHAUST : SINEW_PATH_FILL;
  return c->reference >= 0 || c->pressure > near ? SINEW_PATH_EXHAUST : SINEW_PATH_EVACUATE;
}

static void regulate(sinew_board* board, uint8_t channel, uint32_t dt) {
  sinew_channel* c = &board->channels[channel];
  update_reference(board, c, dt);
  if (c->pressure > c->set_point.limit) {
    set_path(board, channel, SINEW_PATH_EXHAUST, FULL_DUTY);
    return;
  }
  const int32_t off = c->reference > c->pressure ? c->reference - c->pressure : c->pressure - c->reference;
  if (off <= board->settings.hysteresis || c->implausible > 0)
    set_path(board, channel, SINEW_PATH_CLOSED, 0);
  else
    set_path(board, channel, choose_path(board, c), calc_duty(&board->settings, off));
}

static void drive(sinew_board* board, uint8_t channel, uint32_t dt) {
  const sinew_channel* c = &board->channels[channel];
  if (c->mode == SINEW_REGULATE)
    regulate(board, channel, dt);
  else if (c->mode == SINEW_SEAL && c->pressure <= c->configuration.maximum)
    set_path(board, channel, SINEW_PATH_CLOSED, 0);
  else
    set_path(board, channel, SINEW_PATH_EXHAUST, FULL_DUTY);
}

void sinew_board_update(sinew_board* board) {
  const uint32_t now = board->hardware.millis(board->hardware.context);
  const uint32_t passed = now - board->updated_at;
  board->updated_at = now;
  supervise_board(board);
  supervise_source(board, now);
  for (uint8_t i = 0; i < channel_count(board); ++i) {
    supervise_channel(board, i, now);
    drive(board, i, passed < MAX_STEP ? passed : MAX_STEP);
  }
}

/* --- Requests --- */

static bool is_valid(const sinew_board* board, const sinew_configuration* c) {
  if (c->timeout < MIN_TIMEOUT || c->timeout > MAX_TIMEOUT) return false;
  for (uint8_t i = 0; i < c->count; ++i) {
    const sinew_channel_configuration* one = &c->channels[i];
    if (one->maximum < 0 || one->maximum > board->settings.identity.range_max) return false;
    if (one->ramp < 1 || one->ramp > kMaxRamp) return false;
    if (one->on_timeout != SINEW_VENT && one->on_timeout != SINEW_SEAL) return false;
  }
  return true;
}

static bool changes_anything(const sinew_board* board, const sinew_configuration* c) {
  if (!board->armed || c->timeout != board->timeout) return true;
  for (uint8_t i = 0; i < c->count; ++i) {
    const sinew_channel_configuration *a = &c->channels[i], *b = &board->channels[i].configuration;
    if (a->maximum != b->maximum || a->ramp != b->ramp || a->on_timeout != b->on_timeout) return true;
  }
  return false;
}

static bool all_vented(const sinew_board* board) {
  for (uint8_t i = 0; i < channel_count(board); ++i)
    if (board->channels[i].mode != SINEW_VENT) return false;
  return true;
}

uint8_t sinew_board_configure(sinew_board* board, const sinew_configuration* configuration) {
  if (configuration->count != channel_count(board)) return SINEW_WRONG_COUNT;
  if (!is_valid(board, configuration)) return SINEW_OUT_OF_RANGE;
  if (!changes_anything(board, configuration)) return SINEW_ACCEPTED;
  if (!all_vented(board)) return SINEW_BUSY;
  board->timeout = configuration->timeout;
  for (uint8_t i = 0; i < configuration->count; ++i) board->channels[i].configuration = configuration->channels[i];
  board->armed = true;
  return SINEW_ACCEPTED;
}

static bool is_newer(uint16_t sequence, uint16_t last) {
  const uint16_t ahead = (uint16_t)(sequence - last);
  return ahead != 0 && ahead < 0x8000u;
}

uint8_t sinew_board_check_set_point(const sinew_board* board, uint8_t channel, const sinew_set_point* s,
                                    uint16_t sequence) {
  const sinew_channel* c = &board->channels[channel];
  if (c->commanded && !is_newer(sequence, c->sequence)) return SINEW_STALE;
  if (s->mode > SINEW_SEAL) return SINEW_OUT_OF_RANGE;
  if (s->mode == SINEW_VENT) return SINEW_ACCEPTED;
  if (!board->armed) return SINEW_NOT_ARMED;
  if (s->mode == SINEW_SEAL) return SINEW_ACCEPTED;
  if (s->limit < 0 || s->limit > c->configuration.maximum || s->ramp < 1) return SINEW_OUT_OF_RANGE;
  if (s->pressure < board->settings.identity.range_min || s->pressure > s->limit) return SINEW_OUT_OF_RANGE;
  return SINEW_ACCEPTED;
}

void sinew_board_take_set_point(sinew_board* board, uint8_t channel, const sinew_set_point* s, uint16_t sequence) {
  sinew_channel* c = &board->channels[channel];
  const uint32_t now = board->hardware.millis(board->hardware.context);
  c->commanded = board->commanded = true;
  c->sequence = board->accepted = sequence;
  c->commanded_at = board->commanded_at = now;
  c->set_point = *s;
  /* A fault keeps its channel as it is, but a sealed one may always be vented. */
  const uint8_t mode = c->faults != 0 && s->mode != SINEW_VENT ? c->mode : s->mode;
  if (mode == SINEW_REGULATE && c->mode != SINEW_REGULATE) {
    c->reference = c->pressure;
    c->ramp_rest = 0;
  }
  c->mode = mode;
}

static uint8_t take_set_points(sinew_board* board, const sinew_request* request) {
  const sinew_set_point* all = request->as.set_points.channels;
  const uint8_t count = request->as.set_points.count;
  if (count != channel_count(board)) return SINEW_WRONG_COUNT;
  for (uint8_t i = 0; i < count; ++i) {
    const uint8_t reason = sinew_board_check_set_point(board, i, &all[i], request->sequence);
    if (reason != SINEW_ACCEPTED) return reason;
  }
  for (uint8_t i = 0; i < count; ++i) sinew_board_take_set_point(board, i, &all[i], request->sequence);
  return SINEW_ACCEPTED;
}

uint8_t sinew_board_clear_faults(sinew_board* board, uint16_t mask) {
  bool standing = board->hardware.emergency_stop(board->hardware.context) || is_hot(board) || supply_is_bad(board);
  for (uint8_t i = 0; i < channel_count(board); ++i)
    if ((mask >> i & 1u) != 0 && board->channels[i].implausible > 0) standing = true;
  if (standing) return SINEW_BUSY;
  for (uint8_t i = 0; i < channel_count(board); ++i) {
    sinew_channel* c = &board->channels[i];
    if ((mask >> i & 1u) == 0 || c->faults == 0) continue;
    c->faults = 0;
    c->commanded_at = board->hardware.millis(board->hardware.context); /* a sealed channel is given one more timeout */
  }
  board->source_ok_at = board->hardware.millis(board->hardware.context);
  return SINEW_ACCEPTED;
}

void sinew_board_get_configuration(const sinew_board* board, sinew_configuration* configuration) {
  configuration->timeout = board->timeout;
  configuration->count = channel_count(board);
  for (uint8_t i = 0; i < configuration->count; ++i) configuration->channels[i] = board->channels[i].configuration;
}

static uint8_t calc_status(const sinew_channel* c) {
  uint8_t status = c->mode;
  if (c->path == SINEW_PATH_FILL) status |= SINEW_STATUS_FILLING;
  if (c->path == SINEW_PATH_EXHAUST) status |= SINEW_STATUS_EXHAUSTING;
  if (c->path == SINEW_PATH_EVACUATE) status |= SINEW_STATUS_EVACUATING;
  return status;
}

static uint16_t calc_age(const sinew_board* board, uint32_t now) {
  const uint32_t age = now - board->commanded_at;
  return !board->commanded || age >= SINEW_NO_AGE ? SINEW_NO_AGE : (uint16_t)age;
}

void sinew_board_get_state(const sinew_board* board, sinew_state* state) {
  const sinew_hardware* h = &board->hardware;
  const uint32_t now = h->millis(h->context);
  state->uptime = now - board->started_at;
  state->supply = h->supply(h->context);
  state->temperature = h->temperature(h->context);
  state->age = calc_age(board, now);
  state->accepted = board->accepted;
  state->flags = (uint8_t)((board->armed ? SINEW_FLAG_ARMED : 0) | (board->pump ? SINEW_FLAG_PUMP : 0) |
                           (h->emergency_stop(h->context) ? SINEW_FLAG_STOP : 0));
  state->refusal = SINEW_ACCEPTED;
  state->count = channel_count(board);
  for (uint8_t i = 0; i < state->count; ++i) {
    state->channels[i].pressure = board->channels[i].pressure;
    state->channels[i].status = calc_status(&board->channels[i]);
    state->channels[i].faults = board->channels[i].faults;
  }
}

static void answer_state(const sinew_board* board, uint8_t refusal, sinew_answer* answer) {
  answer->type = SINEW_STATE;
  sinew_board_get_state(board, &answer->as.state);
  answer->as.state.refusal = refusal;
}

static void answer_error(uint8_t type, uint8_t reason, sinew_answer* answer) {
  answer->type = SINEW_ERROR;
  answer->as.error.type = type;
  answer->as.error.reason = reason;
}

void sinew_board_handle(sinew_board* board, const sinew_request* request, uint8_t reason, sinew_answer* answer) {
  answer->address = request->address;
  answer->sequence = request->sequence;
  if (reason == SINEW_ACCEPTED && request->type == SINEW_HELLO && request->as.version != SINEW_PROTOCOL_VERSION)
    reason = SINEW_WRONG_VERSION;
  if (reason == SINEW_ACCEPTED && request->type == SINEW_CONFIGURE)
    reason = sinew_board_configure(board, &request->as.configuration);
  if (reason != SINEW_ACCEPTED) {
    answer_error(request->type, reason, answer);
    return;
  }
  switch (request->type) {
    case SINEW_HELLO:
      answer->type = SINEW_IDENTITY;
      answer->as.identity = board->settings.identity;
      break;
    case SINEW_CONFIGURE:
      answer->type = SINEW_CONFIGURATION;
      sinew_board_get_configuration(board, &answer->as.configuration);
      break;
    case SINEW_SET_POINTS:
      answer_state(board, take_set_points(board, request), answer);
      break;
    case SINEW_CLEAR_FAULTS:
      answer_state(board, sinew_board_clear_faults(board, request->as.mask), answer);
      break;
    default:
      answer_state(board, SINEW_ACCEPTED, answer);
  }
}
