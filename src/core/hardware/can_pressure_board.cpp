#include "sinew/hardware/can_pressure_board.h"

namespace sinew {

CanPressureBoard::CanPressureBoard(int address, const DeviceTiming& timing, std::vector<PressureActuator> actuators)
    : board_(address, timing, std::move(actuators)),
      reader_(board_.address()),
      answer_time_(duration(timing.period + timing.reply_timeout)) {
  frames_.reserve(kMaxPressureChannels + 1);
}

void CanPressureBoard::send(CanSender& out) {
  frames_.clear();
  appendPressureFrames(board_.address(), board_.request(), frames_);
  for (const CanFrame& frame : frames_) out.send(frame);
}

// The state that this asks for tells by its sequence that it is later than the request before.
void CanPressureBoard::sendRead(CanSender& out) {
  frames_.clear();
  PressureRequest read;
  read.sequence = board_.request().sequence;
  appendPressureFrames(board_.address(), read, frames_);
  out.send(frames_.front());
}

void CanPressureBoard::sendSetPoints(CanSender& out) {
  send(out);
  set_points_sent_ = true;
}

// --- Set-up ---

void CanPressureBoard::startSetUp(bool) {
  board_.startSetUp();
  reader_.clear();
  waiting_ = false;
}

SetUpProgress CanPressureBoard::updateSetUp(Time now, CanSender& out) {
  if (board_.progress() == SetUpProgress::kDone) {
    board_.prepareSetPoints();
    sendSetPoints(out);
    sendRead(out);
    return SetUpProgress::kDone;
  }
  if (waiting_ && !board_.answered()) {
    if (now - sent_ < answer_time_) return SetUpProgress::kBusy;
    ++counters_.missing;
    board_.missSetUp();
  }
  waiting_ = board_.prepareSetUp(true);
  if (!waiting_) return board_.progress();
  send(out);
  if (board_.request().type == PressureType::kSetPoints) sendRead(out);
  sent_ = now;
  return board_.progress();
}

// --- Cycle ---

void CanPressureBoard::writeSetPoints(const double* set_points, Time, CanSender& out) {
  board_.prepareSetPoints(set_points);
  sendSetPoints(out);
}

void CanPressureBoard::request(Time, CanSender& out) {
  if (!set_points_sent_) board_.prepareRead();
  set_points_sent_ = false;
  sendRead(out);
}

bool CanPressureBoard::take(const CanFrame& frame, Time) {
  switch (reader_.take(frame)) {
    case PressureFrameReader::Progress::kForeign:
      return false;
    case PressureFrameReader::Progress::kDamaged:
      ++counters_.corrupted;
      return true;
    case PressureFrameReader::Progress::kPart:
      return true;
    case PressureFrameReader::Progress::kWhole:
      break;
  }
  PressureAnswer answer = reader_.answer();
  if (answer.type != PressureType::kState) answer.sequence = board_.request().sequence;
  if (!board_.take(answer)) ++counters_.stale;
  counters_.device_error = board_.refusals();
  return true;
}

void CanPressureBoard::endCycle(Time) {
  if (!board_.answered()) ++counters_.missing;
  board_.endCycle();
}

void CanPressureBoard::relax(const bool* which, double share, CanSender& out) {
  board_.relax(which, share);
  board_.prepareSetPoints();
  sendSetPoints(out);
}

void CanPressureBoard::switchOff(const bool* which, CanSender& out) {
  board_.switchOff(which);
  board_.prepareSetPoints();
  sendSetPoints(out);
}

}  // namespace sinew
