/* Bytes and CAN frames of the pressure board protocol, version 1 (docs/pressure_board_protocol.md), as a board sees
 * them: requests are decoded, answers encoded. C99, integers only, no allocation. */
#ifndef SINEW_BOARD_CODEC_H
#define SINEW_BOARD_CODEC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SINEW_PROTOCOL_VERSION 1u
/* Sizes of this build. The protocol knows up to 16 channels and 254 bytes; what does not fit is ignored. */
#ifndef SINEW_MAX_CHANNELS
#ifdef __AVR_ATmega328P__ /* 2 kB of RAM */
#define SINEW_MAX_CHANNELS 4u
#else
#define SINEW_MAX_CHANNELS 8u
#endif
#endif
#ifndef SINEW_MAX_PACKET /* address to CRC */
#ifdef __AVR_ATmega328P__
#define SINEW_MAX_PACKET 96u
#else
#define SINEW_MAX_PACKET 254u
#endif
#endif
#define SINEW_MAX_FRAME (SINEW_MAX_PACKET + 2u) /* stuffed, with its delimiter */
#define SINEW_NO_AGE 0xFFFFu

enum sinew_type {
  SINEW_HELLO = 0x01,
  SINEW_CONFIGURE = 0x02,
  SINEW_SET_POINTS = 0x03,
  SINEW_READ_STATE = 0x04,
  SINEW_CLEAR_FAULTS = 0x05,
  SINEW_BOUNDS = 0x06, /* CAN only */
  SINEW_IDENTITY = 0x81,
  SINEW_CONFIGURATION = 0x82,
  SINEW_STATE = 0x84,
  SINEW_ERROR = 0x8F
};

enum sinew_reason {
  SINEW_ACCEPTED = 0,
  SINEW_UNKNOWN_TYPE = 1,
  SINEW_WRONG_LENGTH = 2,
  SINEW_WRONG_VERSION = 3,
  SINEW_WRONG_COUNT = 4,
  SINEW_OUT_OF_RANGE = 5,
  SINEW_NOT_ARMED = 6,
  SINEW_STALE = 7,
  SINEW_BUSY = 8
};

enum sinew_mode { SINEW_VENT = 0, SINEW_REGULATE = 1, SINEW_SEAL = 2 };

/* Fault bits of a channel. */
enum sinew_fault {
  SINEW_FAULT_SENSOR = 0x01,
  SINEW_FAULT_OVERPRESSURE = 0x02,
  SINEW_FAULT_TIMEOUT = 0x04,
  SINEW_FAULT_STOP = 0x08,
  SINEW_FAULT_SUPPLY = 0x10,
  SINEW_FAULT_TEMPERATURE = 0x20,
  SINEW_FAULT_SOURCE = 0x40
};

/* Bits of a channel's status above the two of its mode. */
enum sinew_status { SINEW_STATUS_FILLING = 0x10, SINEW_STATUS_EXHAUSTING = 0x20, SINEW_STATUS_EVACUATING = 0x40 };

/* Flags of a board. */
enum sinew_flag { SINEW_FLAG_ARMED = 0x01, SINEW_FLAG_PUMP = 0x02, SINEW_FLAG_STOP = 0x04 };

typedef struct {
  uint8_t firmware_major, firmware_minor;
  uint8_t channels;
  uint32_t serial_number;
  int32_t range_min, range_max; /* Pa gauge */
} sinew_identity;

typedef struct {
  int32_t maximum;    /* Pa gauge */
  uint32_t ramp;      /* Pa/s */
  uint8_t on_timeout; /* SINEW_VENT or SINEW_SEAL */
} sinew_channel_configuration;

typedef struct {
  uint16_t timeout; /* ms */
  uint8_t count;
  sinew_channel_configuration channels[SINEW_MAX_CHANNELS];
} sinew_configuration;

typedef struct {
  uint8_t mode;
  int32_t pressure; /* Pa gauge */
  int32_t limit;    /* Pa gauge */
  uint32_t ramp;    /* Pa/s */
} sinew_set_point;

typedef struct {
  uint8_t address;
  uint8_t type;
  uint16_t sequence;
  union {
    uint8_t version;                   /* hello */
    sinew_configuration configuration; /* configure */
    struct {
      uint8_t count;
      sinew_set_point channels[SINEW_MAX_CHANNELS];
    } set_points;
    uint16_t mask; /* clear faults */
  } as;
} sinew_request;

typedef struct {
  int32_t pressure; /* Pa gauge */
  uint8_t status;
  uint8_t faults;
} sinew_channel_state;

typedef struct {
  uint32_t uptime;     /* ms */
  uint16_t supply;     /* mV */
  int16_t temperature; /* 0.1 degC */
  uint16_t age;        /* ms since the last accepted set point, SINEW_NO_AGE before the first and beyond 65534 */
  uint16_t accepted;   /* sequence of that set point */
  uint8_t flags;
  uint8_t refusal; /* why the request that this answers was refused, SINEW_ACCEPTED when it was not */
  uint8_t count;
  sinew_channel_state channels[SINEW_MAX_CHANNELS];
} sinew_state;

typedef struct {
  uint8_t address;
  uint8_t type; /* 0: no answer */
  uint16_t sequence;
  union {
    sinew_identity identity;
    sinew_configuration configuration;
    sinew_state state;
    struct {
      uint8_t type, reason;
    } error;
  } as;
} sinew_answer;

/* CRC-16/IBM-3740: polynomial 1021, initial FFFF, not reflected. */
uint16_t sinew_crc(const uint8_t* data, size_t size);

/* Stuffs `size` <= 254 bytes; `out` has room for one more. Returns the bytes written. */
size_t sinew_stuff(const uint8_t* data, size_t size, uint8_t* out);
/* Takes the stuffing out, `out` may be `data`. Returns the bytes written, 0 when the stuffing is broken. */
size_t sinew_unstuff(const uint8_t* data, size_t size, uint8_t* out);

/* Whether `packet`, unstuffed, is sound: whole header, right CRC. */
bool sinew_packet_is_sound(const uint8_t* packet, size_t size);
/* Reads a sound packet; other than SINEW_ACCEPTED when its type or length is none of the protocol's. Address, type and
 * sequence are read in any case. */
uint8_t sinew_decode_request(const uint8_t* packet, size_t size, sinew_request* request);
/* Writes stuffed bytes with their delimiter into `frame` of SINEW_MAX_FRAME bytes and returns how many. */
size_t sinew_encode_answer(const sinew_answer* answer, uint8_t* frame);

typedef struct {
  uint32_t id; /* 29 bits */
  uint8_t size;
  uint8_t data[8];
} sinew_can_frame;

#define SINEW_CAN_PREFIX 0x15000000ul
#define SINEW_CAN_LAST 0xFFu /* index of the frame that ends a message of several */
#define SINEW_CAN_BOARD 0xFEu
#define SINEW_MAX_CAN_FRAMES (SINEW_MAX_CHANNELS + 2u)

/* A request's frame taken apart; which members count depends on type and index. */
typedef struct {
  uint8_t type, index;
  uint16_t sequence;
  uint16_t mask;    /* clear faults; on configure the channels that seal */
  uint16_t timeout; /* ms */
  uint8_t count;    /* configure */
  uint8_t version;  /* hello */
  uint8_t mode;     /* set point */
  int32_t pressure; /* Pa gauge: set point, limit or maximum */
  uint32_t ramp;    /* Pa/s */
} sinew_can_request;

/* Whether the frame is a request to `address`. */
bool sinew_can_is_request(uint32_t id, uint8_t address);
/* Reads such a frame; other than SINEW_ACCEPTED when its type or length is none of the protocol's. */
uint8_t sinew_can_decode(const sinew_can_frame* frame, sinew_can_request* request);
/* Writes the frames of an answer, at most SINEW_MAX_CAN_FRAMES, and returns how many. */
size_t sinew_can_encode(const sinew_answer* answer, sinew_can_frame* frames);

#ifdef __cplusplus
}
#endif
#endif
