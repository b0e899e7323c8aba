/* What a pressure board does: keeps its channels' pressures at their set points within limits of its own, and vents
 * whatever nobody speaks for. Portable C99, integers only, no allocation; the hardware is reached through callbacks. */
#ifndef SINEW_BOARD_H
#define SINEW_BOARD_H

#include "sinew_board_codec.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The way that a channel's valves open. */
typedef enum {
  SINEW_PATH_CLOSED,
  SINEW_PATH_FILL,    /* from the pressure source */
  SINEW_PATH_EXHAUST, /* to the atmosphere; where the valves rest without power */
  SINEW_PATH_EVACUATE /* to the vacuum source */
} sinew_path;

/* The hardware. Every function is given `context`. */
typedef struct {
  void* context;
  uint32_t (*millis)(void* context);
  int32_t (*pressure)(void* context, uint8_t channel); /* Pa gauge; far beyond the range when the sensor is broken */
  int32_t (*source_pressure)(void* context);           /* Pa gauge in the tank */
  uint16_t (*supply)(void* context);                   /* mV */
  int16_t (*temperature)(void* context);               /* 0.1 degC */
  bool (*emergency_stop)(void* context);               /* true while it is pressed, or its wire is broken */
  void (*set_valves)(void* context, uint8_t channel, sinew_path path, uint8_t duty); /* duty of 255 */
  void (*set_pump)(void* context, bool on);
} sinew_hardware;

typedef struct {
  sinew_identity identity;
  int32_t hysteresis;              /* Pa around the reference within which the valves stay closed */
  int32_t proportional_band;       /* Pa beyond it over which the duty rises from least to full: at least twice what an
                                      open valve changes between two updates; 0 for valves that only switch */
  uint8_t least_duty;              /* of 255, from which on a valve opens at all */
  uint16_t supply_min, supply_max; /* mV */
  int16_t temperature_max;         /* 0.1 degC */
  int32_t source_low, source_high; /* Pa gauge between which the pump keeps the tank; both 0 without a pump */
  uint32_t source_time;            /* ms that the tank may stay below source_low while a channel regulates */
} sinew_board_settings;

typedef struct {
  sinew_channel_configuration configuration;
  sinew_set_point set_point; /* the last accepted one */
  uint8_t mode;              /* in force */
  uint8_t faults;
  bool commanded;        /* whether any set point was accepted since the board started */
  uint16_t sequence;     /* of the last accepted set point */
  uint32_t commanded_at; /* ms */
  int32_t pressure;      /* Pa gauge, measured */
  int32_t reference;     /* Pa gauge, follows the set point at the ramp */
  uint32_t ramp_rest;    /* of the ramp, in Pa/1000, not yet in the reference */
  uint8_t implausible;   /* readings in a row beyond the sensor's range */
  sinew_path path;
} sinew_channel;

typedef struct {
  sinew_hardware hardware;
  sinew_board_settings settings;
  sinew_channel channels[SINEW_MAX_CHANNELS];
  bool armed;
  uint16_t timeout;                /* ms */
  uint32_t started_at, updated_at; /* ms */
  bool commanded;
  uint16_t accepted;     /* sequence of the newest accepted set point */
  uint32_t commanded_at; /* ms */
  uint8_t supply_misses; /* readings in a row outside of the supply's range */
  bool pump;
  uint32_t source_ok_at; /* ms when the tank last had pressure, or nobody needed it */
} sinew_board;

/* Vents every channel, as after power-up. */
void sinew_board_start(sinew_board* board, const sinew_board_settings* settings, const sinew_hardware* hardware);
/* Reads the sensors and moves the valves; call every 1 to 10 ms. */
void sinew_board_update(sinew_board* board);

/* Acts on a decoded request and fills in its answer, address and all. `reason` is the decoder's. */
void sinew_board_handle(sinew_board* board, const sinew_request* request, uint8_t reason, sinew_answer* answer);

/* The parts of it, for links that bring a message in pieces. Each returns a sinew_reason. */
uint8_t sinew_board_configure(sinew_board* board, const sinew_configuration* configuration);
uint8_t sinew_board_check_set_point(const sinew_board* board, uint8_t channel, const sinew_set_point* set_point,
                                    uint16_t sequence);
void sinew_board_take_set_point(sinew_board* board, uint8_t channel, const sinew_set_point* set_point,
                                uint16_t sequence);
uint8_t sinew_board_clear_faults(sinew_board* board, uint16_t mask);
void sinew_board_get_configuration(const sinew_board* board, sinew_configuration* configuration);
void sinew_board_get_state(const sinew_board* board, sinew_state* state);

#ifdef __cplusplus
}
#endif
#endif
