#include "sinew_board_codec.h"

#include <string.h>

/* --- Little-endian numbers --- */

static uint16_t get16(const uint8_t* p) {
  return (uint16_t)(p[0] | ((uint16_t)p[1] << 8));
}

static uint32_t get32(const uint8_t* p) {
  return (uint32_t)get16(p) | ((uint32_t)get16(p + 2) << 16);
}

/* Two's complement without relying on how the compiler narrows. */
static int32_t get_signed(const uint8_t* p) {
  const uint32_t u = get32(p);
  return u <= 0x7FFFFFFFul ? (int32_t)u : -(int32_t)(0xFFFFFFFFul - u) - 1;
}

static uint8_t* put16(uint8_t* p, uint16_t value) {
  p[0] = (uint8_t)(value & 0xFFu);
  p[1] = (uint8_t)(value >> 8);
  return p + 2;
}

static uint8_t* put32(uint8_t* p, uint32_t value) {
  return put16(put16(p, (uint16_t)(value & 0xFFFFu)), (uint16_t)(value >> 16));
}

static uint8_t* put_signed(uint8_t* p, int32_t value) {
  return put32(p, (uint32_t)value);
}

/* --- Framing --- */

uint16_t sinew_crc(const uint8_t* data, size_t size) {
  uint16_t crc = 0xFFFFu;
  for (size_t i = 0; i < size; ++i) {
    crc = (uint16_t)(crc ^ ((uint16_t)data[i] << 8));
    for (uint8_t bit = 0; bit < 8; ++bit)
      crc = (uint16_t)((crc & 0x8000u) ? ((uint32_t)crc << 1) ^ 0x1021u : (uint32_t)crc << 1);
  }
  return crc;
}

size_t sinew_stuff(const uint8_t* data, size_t size, uint8_t* out) {
  size_t code = 0; /* where the distance to the next zero goes */
  size_t end = 1;
  for (size_t i = 0; i < size; ++i) {
    if (data[i] != 0) {
      out[end++] = data[i];
      continue;
    }
    out[code] = (uint8_t)(end - code);
    code = end++;
  }
  out[code] = (uint8_t)(end - code);
  return end;
}

size_t sinew_unstuff(const uint8_t* data, size_t size, uint8_t* out) {
  size_t end = 0;
  for (size_t i = 0; i < size;) {
    const size_t code = data[i];
    if (code == 0 || i + code > size) return 0;
    for (size_t k = 1; k < code; ++k) {
      if (data[i + k] == 0) return 0;
      out[end++] = data[i + k];
    }
    i += code;
    if (code != 0xFFu && i < size) out[end++] = 0;
  }
  return end;
}

enum { HEADER_SIZE = 4, CRC_SIZE = 2 };

bool sinew_packet_is_sound(const uint8_t* packet, size_t size) {
  if (size < HEADER_SIZE + CRC_SIZE || size > SINEW_MAX_PACKET) return false;
  return get16(packet + size - CRC_SIZE) == sinew_crc(packet, size - CRC_SIZE);
}

/* --- Requests --- */

static uint8_t decode_configuration(const uint8_t* p, size_t size, sinew_configuration* c) {
  if (size < 3) return SINEW_WRONG_LENGTH;
  c->timeout = get16(p);
  c->count = p[2];
  if (size != 3u + 9u * c->count) return SINEW_WRONG_LENGTH;
  if (c->count > SINEW_MAX_CHANNELS) return SINEW_WRONG_COUNT;
  p += 3;
  for (uint8_t i = 0; i < c->count; ++i, p += 9) {
    c->channels[i].maximum = get_signed(p);
    c->channels[i].ramp = get32(p + 4);
    c->channels[i].on_timeout = p[8];
  }
  return SINEW_ACCEPTED;
}

static uint8_t decode_set_points(const uint8_t* p, size_t size, sinew_request* request) {
  const uint8_t count = size > 0 ? p[0] : 0;
  if (size != 1u + 13u * count) return SINEW_WRONG_LENGTH;
  if (count > SINEW_MAX_CHANNELS) return SINEW_WRONG_COUNT;
  request->as.set_points.count = count;
  ++p;
  for (uint8_t i = 0; i < count; ++i, p += 13) {
    sinew_set_point* s = &request->as.set_points.channels[i];
    s->mode = p[0];
    s->pressure = get_signed(p + 1);
    s->limit = get_signed(p + 5);
    s->ramp = get32(p + 9);
  }
  return SINEW_ACCEPTED;
}

uint8_t sinew_decode_request(const uint8_t* packet, size_t size, sinew_request* request) {
  const uint8_t* payload = packet + HEADER_SIZE;
  const size_t length = size - HEADER_SIZE - CRC_SIZE;
  request->address = packet[0];
  request->type = packet[1];
  request->sequence = get16(packet + 2);
  switch (request->type) {
    case SINEW_HELLO:
      request->as.version = length == 1 ? payload[0] : 0;
      return length == 1 ? SINEW_ACCEPTED : SINEW_WRONG_LENGTH;
    case SINEW_CONFIGURE:
      return decode_configuration(payload, length, &request->as.configuration);
    case SINEW_SET_POINTS:
      return decode_set_points(payload, length, request);
    case SINEW_READ_STATE:
      return length == 0 ? SINEW_ACCEPTED : SINEW_WRONG_LENGTH;
    case SINEW_CLEAR_FAULTS:
      request->as.mask = length == 2 ? get16(payload) : 0;
      return length == 2 ? SINEW_ACCEPTED : SINEW_WRONG_LENGTH;
    default:
      return SINEW_UNKNOWN_TYPE;
  }
}

/* --- Answers --- */

static uint8_t* put_identity(uint8_t* p, const sinew_identity* identity) {
  *p++ = SINEW_PROTOCOL_VERSION;
  *p++ = identity->firmware_major;
  *p++ = identity->firmware_minor;
  *p++ = identity->channels;
  p = put32(p, identity->serial_number);
  p = put_signed(p, identity->range_min);
  return put_signed(p, identity->range_max);
}

static uint8_t* put_configuration(uint8_t* p, const sinew_configuration* c) {
  p = put16(p, c->timeout);
  *p++ = c->count;
  for (uint8_t i = 0; i < c->count; ++i) {
    p = put_signed(p, c->channels[i].maximum);
    p = put32(p, c->channels[i].ramp);
    *p++ = c->channels[i].on_timeout;
  }
  return p;
}

static uint8_t* put_state(uint8_t* p, const sinew_state* state) {
  p = put32(p, state->uptime);
  p = put16(p, state->supply);
  p = put16(p, (uint16_t)state->temperature);
  p = put16(p, state->age);
  p = put16(p, state->accepted);
  *p++ = state->flags;
  *p++ = state->refusal;
  *p++ = state->count;
  for (uint8_t i = 0; i < state->count; ++i) {
    p = put_signed(p, state->channels[i].pressure);
    *p++ = state->channels[i].status;
    *p++ = state->channels[i].faults;
  }
  return p;
}

size_t sinew_encode_answer(const sinew_answer* answer, uint8_t* frame) {
  uint8_t packet[SINEW_MAX_PACKET];
  uint8_t* p = packet;
  *p++ = answer->address;
  *p++ = answer->type;
  p = put16(p, answer->sequence);
  if (answer->type == SINEW_IDENTITY) p = put_identity(p, &answer->as.identity);
  if (answer->type == SINEW_CONFIGURATION) p = put_configuration(p, &answer->as.configuration);
  if (answer->type == SINEW_STATE) p = put_state(p, &answer->as.state);
  if (answer->type == SINEW_ERROR) {
    *p++ = answer->as.error.type;
    *p++ = answer->as.error.reason;
  }
  p = put16(p, sinew_crc(packet, (size_t)(p - packet)));
  const size_t size = sinew_stuff(packet, (size_t)(p - packet), frame);
  frame[size] = 0;
  return size + 1;
}

/* --- CAN --- */

static uint32_t can_id(uint8_t type, uint8_t address, uint8_t index) {
  return SINEW_CAN_PREFIX | ((uint32_t)type << 16) | ((uint32_t)address << 8) | index;
}

bool sinew_can_is_request(uint32_t id, uint8_t address) {
  return (id & 0x1F80FF00ul) == (SINEW_CAN_PREFIX | ((uint32_t)address << 8));
}

uint8_t sinew_can_decode(const sinew_can_frame* frame, sinew_can_request* request) {
  const uint8_t* p = frame->data;
  uint8_t size;
  memset(request, 0, sizeof *request);
  request->type = (uint8_t)((frame->id >> 16) & 0xFFu);
  request->index = (uint8_t)(frame->id & 0xFFu);
  const bool last = request->index == SINEW_CAN_LAST;
  switch (request->type) {
    case SINEW_HELLO:
      size = 1;
      break;
    case SINEW_CONFIGURE:
      size = last ? 5 : 8;
      break;
    case SINEW_SET_POINTS:
      size = 7;
      break;
    case SINEW_READ_STATE:
      size = 2;
      break;
    case SINEW_CLEAR_FAULTS:
      size = 4;
      break;
    case SINEW_BOUNDS:
      size = 8;
      break;
    default:
      return SINEW_UNKNOWN_TYPE;
  }
  if (frame->size != size) return SINEW_WRONG_LENGTH;
  switch (request->type) {
    case SINEW_HELLO:
      request->version = p[0];
      break;
    case SINEW_READ_STATE:
      request->sequence = get16(p);
      break;
    case SINEW_CLEAR_FAULTS:
      request->sequence = get16(p);
      request->mask = get16(p + 2);
      break;
    case SINEW_SET_POINTS:
      request->pressure = get_signed(p);
      request->sequence = get16(p + 4);
      request->mode = p[6];
      break;
    default:
      if (request->type == SINEW_CONFIGURE && last) {
        request->timeout = get16(p);
        request->mask = get16(p + 2);
        request->count = p[4];
      } else {
        request->pressure = get_signed(p);
        request->ramp = get32(p + 4);
      }
  }
  return SINEW_ACCEPTED;
}

typedef struct {
  sinew_can_frame* next;
  uint8_t type, address;
} can_writer;

/* Begins a frame; returns where its data goes. */
static uint8_t* add_frame(can_writer* w, uint8_t index, uint8_t size) {
  sinew_can_frame* frame = w->next++;
  memset(frame, 0, sizeof *frame);
  frame->id = can_id(w->type, w->address, index);
  frame->size = size;
  return frame->data;
}

static void add_identity(can_writer* w, const sinew_identity* identity) {
  uint8_t* p = add_frame(w, 0, 8);
  p[0] = SINEW_PROTOCOL_VERSION;
  p[1] = identity->firmware_major;
  p[2] = identity->firmware_minor;
  p[3] = identity->channels;
  put32(p + 4, identity->serial_number);
  p = add_frame(w, SINEW_CAN_LAST, 8);
  put_signed(put_signed(p, identity->range_min), identity->range_max);
}

static void add_configuration(can_writer* w, const sinew_configuration* c) {
  uint16_t seals = 0;
  for (uint8_t i = 0; i < c->count; ++i) {
    put32(put_signed(add_frame(w, i, 8), c->channels[i].maximum), c->channels[i].ramp);
    if (c->channels[i].on_timeout == SINEW_SEAL) seals = (uint16_t)(seals | (1u << i));
  }
  uint8_t* p = add_frame(w, SINEW_CAN_LAST, 5);
  *put16(put16(p, c->timeout), seals) = c->count;
}

static void add_state(can_writer* w, const sinew_state* state, uint16_t sequence) {
  for (uint8_t i = 0; i < state->count; ++i) {
    uint8_t* p = put_signed(add_frame(w, i, 8), state->channels[i].pressure);
    *p++ = state->channels[i].status;
    *p++ = state->channels[i].faults;
    put16(p, sequence);
  }
  uint8_t* p = put32(add_frame(w, SINEW_CAN_BOARD, 8), state->uptime);
  put16(put16(p, state->supply), (uint16_t)state->temperature);
  p = put16(put16(add_frame(w, SINEW_CAN_LAST, 8), state->age), state->accepted);
  *p++ = state->flags;
  *p++ = state->refusal;
  put16(p, sequence);
}

size_t sinew_can_encode(const sinew_answer* answer, sinew_can_frame* frames) {
  can_writer w;
  w.next = frames;
  w.type = answer->type;
  w.address = answer->address;
  if (answer->type == SINEW_IDENTITY) add_identity(&w, &answer->as.identity);
  if (answer->type == SINEW_CONFIGURATION) add_configuration(&w, &answer->as.configuration);
  if (answer->type == SINEW_STATE) add_state(&w, &answer->as.state, answer->sequence);
  if (answer->type == SINEW_ERROR) {
    uint8_t* p = add_frame(&w, SINEW_CAN_LAST, 2);
    p[0] = answer->as.error.type;
    p[1] = answer->as.error.reason;
  }
  return (size_t)(w.next - frames);
}
