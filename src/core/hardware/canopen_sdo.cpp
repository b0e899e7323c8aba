#include "sinew/hardware/canopen_sdo.h"

#include <algorithm>

namespace sinew {

using canopen::SdoReply;

CanopenSdo::CanopenSdo(std::uint8_t node, Duration timeout, int tries)
    : node_(node), timeout_(timeout), tries_(tries) {}

void CanopenSdo::startUpload(canopen::ObjectAddress object) {
  start(Phase::kUpload, object);
}

void CanopenSdo::startDownload(canopen::ObjectAddress object, const std::uint8_t* data, std::size_t size) {
  std::copy(data, data + size, data_.begin());
  size_ = size;
  start(Phase::kDownload, object);
}

void CanopenSdo::startDownload(canopen::ObjectAddress object, std::uint32_t value, std::size_t size) {
  std::uint8_t data[canopen::kExpeditedSize];
  canopen::storeNumber(value, size, data);
  startDownload(object, data, size);
}

void CanopenSdo::start(Phase phase, canopen::ObjectAddress object) {
  first_phase_ = phase;
  object_ = object;
  status_ = Status::kBusy;
  abort_code_ = 0;
  abort_due_ = false;
  tries_left_ = tries_;
  restart();
}

void CanopenSdo::restart() {
  phase_ = first_phase_;
  if (isUpload()) size_ = 0;
  offset_ = 0;
  sized_ = toggle_ = has_last_segment_ = false;
  due_ = true;
}

std::uint32_t CanopenSdo::value() const {
  return canopen::loadNumber(data_.data(), std::min(size_, canopen::kExpeditedSize));
}

std::int32_t CanopenSdo::signedValue() const {
  return size_ == 0 ? 0 : canopen::loadSigned(data_.data(), std::min(size_, canopen::kExpeditedSize));
}

void CanopenSdo::update(Time now, CanSender& out) {
  if (abort_due_) {
    out.send(canopen::makeSdoAbort(node_, object_, abort_code_));
    abort_due_ = false;
  }
  if (status_ != Status::kBusy) return;
  if (!due_) {
    if (now < deadline_) return;
    if (phase_ != first_phase_ || tries_left_ <= 1)
      out.send(canopen::makeSdoAbort(node_, object_, canopen::kAbortTimeout));
    if (--tries_left_ <= 0) {
      status_ = Status::kSilent;
      return;
    }
    restart();
  }
  out.send(makeRequest());  // one that does not get out counts as one that is not answered
  due_ = false;
  deadline_ = now + timeout_;
}

std::size_t CanopenSdo::nextSegment() const {
  return std::min(size_ - offset_, canopen::kSegmentSize);
}

CanFrame CanopenSdo::makeRequest() const {
  switch (phase_) {
    case Phase::kUpload:
      return canopen::makeSdoUpload(node_, object_);
    case Phase::kUploadSegments:
      return canopen::makeSdoUploadSegment(node_, toggle_);
    case Phase::kDownloadSegments:
      return canopen::makeSdoDownloadSegment(node_, toggle_, offset_ + nextSegment() == size_, &data_[offset_],
                                             nextSegment());
    default:
      return size_ <= canopen::kExpeditedSize ? canopen::makeSdoDownload(node_, object_, data_.data(), size_)
                                              : canopen::makeSdoDownloadStart(node_, object_, size_);
  }
}

bool CanopenSdo::take(const CanFrame& frame) {
  if (frame.id != canopen::kSdoReplyId + node_ || frame.extended) return false;
  SdoReply reply;
  if (!canopen::readSdoReply(frame, node_, reply)) {
    ++malformed_;
    return true;
  }
  const bool segment = phase_ != first_phase_;
  const bool doubled = has_last_segment_ && reply.toggle != toggle_ && frame.data == last_segment_;
  if (status_ != Status::kBusy || due_ || !fits(reply) || (segment && doubled)) {
    ++stale_;
  } else if (reply.kind == SdoReply::Kind::kAbort) {
    status_ = Status::kAborted;
    abort_code_ = reply.abort_code;
  } else if (segment && reply.toggle != toggle_) {
    abort(canopen::kAbortToggle);
  } else {
    last_segment_ = frame.data;
    has_last_segment_ = segment;
    advance(reply);
  }
  return true;
}

// Whether the reply can answer what was asked last. Segments do not name their object.
bool CanopenSdo::fits(const SdoReply& reply) const {
  switch (reply.kind) {
    case SdoReply::Kind::kUpload:
    case SdoReply::Kind::kUploadStart:
      return phase_ == Phase::kUpload && reply.object == object_;
    case SdoReply::Kind::kUploadSegment:
      return phase_ == Phase::kUploadSegments;
    case SdoReply::Kind::kDownload:
      return phase_ == Phase::kDownload && reply.object == object_;
    case SdoReply::Kind::kDownloadSegment:
      return phase_ == Phase::kDownloadSegments;
    default:
      return reply.object == object_;
  }
}

void CanopenSdo::advance(const SdoReply& reply) {
  switch (reply.kind) {
    case SdoReply::Kind::kUpload:
      std::copy_n(reply.data.begin(), reply.size, data_.begin());
      size_ = reply.size;
      status_ = Status::kDone;
      break;
    case SdoReply::Kind::kUploadStart:
      takeUploadStart(reply);
      break;
    case SdoReply::Kind::kUploadSegment:
      takeUploadSegment(reply);
      break;
    case SdoReply::Kind::kDownload:
      if (size_ <= canopen::kExpeditedSize) {
        status_ = Status::kDone;
      } else {
        phase_ = Phase::kDownloadSegments;
        due_ = true;
      }
      break;
    default:
      takeDownloadSegment();
  }
}

void CanopenSdo::takeUploadStart(const SdoReply& reply) {
  if (reply.size > kCapacity) return abort(canopen::kAbortMemory);
  sized_ = reply.sized;
  size_ = reply.size;
  phase_ = Phase::kUploadSegments;
  due_ = true;
}

void CanopenSdo::takeUploadSegment(const SdoReply& reply) {
  if (reply.size > kCapacity - offset_) return abort(canopen::kAbortMemory);
  std::copy_n(reply.data.begin(), reply.size, &data_[0] + offset_);
  offset_ += reply.size;
  toggle_ = !toggle_;
  if (sized_ && (offset_ > size_ || (reply.last && offset_ != size_))) return abort(canopen::kAbortLength);
  if (reply.last) {
    size_ = offset_;
    status_ = Status::kDone;
  }
  due_ = !reply.last;
}

void CanopenSdo::takeDownloadSegment() {
  offset_ += nextSegment();
  toggle_ = !toggle_;
  due_ = offset_ < size_;
  if (!due_) status_ = Status::kDone;
}

void CanopenSdo::abort(std::uint32_t code) {
  status_ = Status::kAborted;
  abort_code_ = code;
  abort_due_ = true;
}

}  // namespace sinew
