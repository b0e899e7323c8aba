/* How requests reach a board: a serial line, byte by byte, or a CAN bus, frame by frame. */
#ifndef SINEW_BOARD_LINK_H
#define SINEW_BOARD_LINK_H

#include "sinew_board.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  sinew_board* board;
  uint8_t address;
  uint16_t size;
  bool overflown; /* longer than any frame: skipped up to the next delimiter */
  uint8_t frame[SINEW_MAX_FRAME];
} sinew_serial_link;

void sinew_serial_start(sinew_serial_link* link, sinew_board* board, uint8_t address);
/* Takes a byte of the line. Returns how many bytes of `answer` (room for SINEW_MAX_FRAME) are to be sent now. */
size_t sinew_serial_take(sinew_serial_link* link, uint8_t byte, uint8_t* answer);

typedef struct {
  sinew_board* board;
  uint8_t address;
  sinew_configuration staged;
  uint16_t staged_channels;                   /* one bit each */
  sinew_set_point bounds[SINEW_MAX_CHANNELS]; /* limit and ramp that came by themselves */
  uint8_t refusal;                            /* of set points since the last state */
} sinew_can_link;

void sinew_can_start(sinew_can_link* link, sinew_board* board, uint8_t address);
/* Takes a frame of the bus. Returns how many of `answer` (room for SINEW_MAX_CAN_FRAMES) are to be sent now. */
size_t sinew_can_take(sinew_can_link* link, const sinew_can_frame* frame, sinew_can_frame* answer);

#ifdef __cplusplus
}
#endif
#endif
