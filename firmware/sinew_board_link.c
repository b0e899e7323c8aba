#include "sinew_board_link.h"

#include <string.h>

/* --- Serial --- */

void sinew_serial_start(sinew_serial_link* link, sinew_board* board, uint8_t address) {
  memset(link, 0, sizeof *link);
  link->board = board;
  link->address = address;
}

static size_t handle_packet(sinew_serial_link* link, size_t size, uint8_t* out) {
  const uint8_t* packet = link->frame;
  if (!sinew_packet_is_sound(packet, size) || packet[0] != link->address) return 0;
  if ((packet[1] & 0x80u) != 0) return 0; /* an answer: its own, echoed by a two-wire line */
  sinew_request request;
  sinew_answer answer;
  const uint8_t reason = sinew_decode_request(packet, size, &request);
  sinew_board_handle(link->board, &request, reason, &answer);
  return sinew_encode_answer(&answer, out);
}

size_t sinew_serial_take(sinew_serial_link* link, uint8_t byte, uint8_t* answer) {
  if (byte != 0) {
    if (link->size < sizeof link->frame)
      link->frame[link->size++] = byte;
    else
      link->overflown = true;
    return 0;
  }
  const size_t size = link->overflown ? 0 : sinew_unstuff(link->frame, link->size, link->frame);
  link->size = 0;
  link->overflown = false;
  return handle_packet(link, size, answer);
}

/* --- CAN --- */

static void reset_bounds(sinew_can_link* link) {
  for (uint8_t i = 0; i < link->board->settings.identity.channels; ++i) {
    link->bounds[i].limit = link->board->channels[i].configuration.maximum;
    link->bounds[i].ramp = link->board->channels[i].configuration.ramp;
  }
}

void sinew_can_start(sinew_can_link* link, sinew_board* board, uint8_t address) {
  memset(link, 0, sizeof *link);
  link->board = board;
  link->address = address;
  reset_bounds(link);
}

static void stage_channel(sinew_can_link* link, const sinew_can_request* r) {
  link->staged.channels[r->index].maximum = r->pressure;
  link->staged.channels[r->index].ramp = r->ramp;
  link->staged_channels = (uint16_t)(link->staged_channels | (1u << r->index));
}

/* The last frame puts the staged channels into force, if all of them have come. */
static uint8_t finish_configuration(sinew_can_link* link, const sinew_can_request* r, sinew_request* request) {
  const uint8_t channels = link->board->settings.identity.channels;
  const bool whole = link->staged_channels == (uint16_t)((1ul << channels) - 1u) && r->count == channels;
  link->staged_channels = 0;
  link->staged.timeout = r->timeout;
  link->staged.count = r->count;
  for (uint8_t i = 0; i < channels; ++i)
    link->staged.channels[i].on_timeout = (r->mask >> i & 1u) != 0 ? SINEW_SEAL : SINEW_VENT;
  request->as.configuration = link->staged;
  return whole ? SINEW_ACCEPTED : SINEW_WRONG_COUNT;
}

static void take_set_point(sinew_can_link* link, const sinew_can_request* r) {
  sinew_set_point s = link->bounds[r->index];
  s.mode = r->mode;
  s.pressure = r->pressure;
  const uint8_t reason = sinew_board_check_set_point(link->board, r->index, &s, r->sequence);
  if (reason == SINEW_ACCEPTED)
    sinew_board_take_set_point(link->board, r->index, &s, r->sequence);
  else
    link->refusal = reason;
}

/* Frames of one channel, without an answer of their own. Returns whether `r` was one. */
static bool take_channel_frame(sinew_can_link* link, const sinew_can_request* r) {
  const bool is_bounds = r->type == SINEW_BOUNDS, is_set_point = r->type == SINEW_SET_POINTS;
  const bool is_staged = r->type == SINEW_CONFIGURE && r->index != SINEW_CAN_LAST;
  if (!is_bounds && !is_set_point && !is_staged) return false;
  if (r->index >= link->board->settings.identity.channels) {
    link->refusal = SINEW_WRONG_COUNT;
  } else if (is_staged) {
    stage_channel(link, r);
  } else if (is_set_point) {
    take_set_point(link, r);
  } else {
    link->bounds[r->index].limit = r->pressure;
    link->bounds[r->index].ramp = r->ramp;
  }
  return true;
}

size_t sinew_can_take(sinew_can_link* link, const sinew_can_frame* frame, sinew_can_frame* out) {
  sinew_can_request r;
  sinew_request request;
  sinew_answer answer;
  if (!sinew_can_is_request(frame->id, link->address)) return 0;
  uint8_t reason = sinew_can_decode(frame, &r);
  if (reason == SINEW_ACCEPTED && take_channel_frame(link, &r)) return 0;
  memset(&request, 0, sizeof request);
  request.address = link->address;
  request.type = r.type;
  request.sequence = r.sequence;
  if (r.type == SINEW_HELLO) request.as.version = r.version;
  if (r.type == SINEW_CLEAR_FAULTS) request.as.mask = r.mask;
  if (r.type == SINEW_CONFIGURE && reason == SINEW_ACCEPTED) reason = finish_configuration(link, &r, &request);
  sinew_board_handle(link->board, &request, reason, &answer);
  if (answer.type == SINEW_CONFIGURATION) reset_bounds(link);
  if (answer.type == SINEW_STATE) {
    if (answer.as.state.refusal == SINEW_ACCEPTED) answer.as.state.refusal = link->refusal;
    link->refusal = SINEW_ACCEPTED;
  }
  return sinew_can_encode(&answer, out);
}
