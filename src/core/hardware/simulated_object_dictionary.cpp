#include "sinew/hardware/simulated_object_dictionary.h"

#include <algorithm>
#include <stdexcept>

namespace sinew {
namespace {

constexpr std::size_t kMaxTransfer = 4096;  // bytes that the server keeps of a download

bool holds(std::uint8_t byte, unsigned mask) {
  return (byte & mask) != 0;
}

}  // namespace

// --- Dictionary ---

void SimulatedObjectDictionary::setHooks(Check check, Written written) {
  check_ = std::move(check);
  written_ = std::move(written);
}

void SimulatedObjectDictionary::addText(std::uint16_t index, const std::string& text, std::size_t capacity) {
  texts_.push_back({index, text, capacity});
}

void SimulatedObjectDictionary::reset(std::uint16_t first, std::uint16_t last) {
  for (Entry& e : entries_)
    if (e.index >= first && e.index <= last) e.value = e.initial;
}

const SimulatedObjectDictionary::Entry* SimulatedObjectDictionary::find(std::uint16_t index,
                                                                        std::uint8_t subindex) const {
  for (const Entry& e : entries_)
    if (e.index == index && e.subindex == subindex) return &e;
  return nullptr;
}

SimulatedObjectDictionary::Entry* SimulatedObjectDictionary::find(std::uint16_t index, std::uint8_t subindex) {
  return const_cast<Entry*>(std::as_const(*this).find(index, subindex));
}

std::int64_t SimulatedObjectDictionary::get(std::uint16_t index, std::uint8_t subindex) const {
  const Entry* e = find(index, subindex);
  if (e == nullptr) throw std::logic_error("simulated drive without object " + std::to_string(index));
  return e->value;
}

void SimulatedObjectDictionary::set(std::uint16_t index, std::uint8_t subindex, std::int64_t value) {
  Entry* e = find(index, subindex);
  if (e == nullptr) throw std::logic_error("simulated drive without object " + std::to_string(index));
  e->value = value;
}

// No such object, or no such subindex of it.
std::uint32_t SimulatedObjectDictionary::whyMissing(std::uint16_t index) const {
  const auto has = [&](const auto& e) { return e.index == index; };
  const bool known =
      std::any_of(entries_.begin(), entries_.end(), has) || std::any_of(texts_.begin(), texts_.end(), has);
  return known ? 0x06090011 : 0x06020000;
}

std::uint32_t SimulatedObjectDictionary::read(std::uint16_t index, std::uint8_t subindex,
                                              std::vector<std::uint8_t>& data) const {
  for (const Text& t : texts_) {
    if (t.index != index || subindex != 0) continue;
    data.assign(t.value.begin(), t.value.end());
    return 0;
  }
  const Entry* e = find(index, subindex);
  if (e == nullptr) return whyMissing(index);
  data.clear();
  for (unsigned i = 0; i < e->size; ++i)
    data.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(e->value) >> (8 * i)));
  return 0;
}

std::uint32_t SimulatedObjectDictionary::write(std::uint16_t index, std::uint8_t subindex,
                                               const std::vector<std::uint8_t>& data) {
  for (Text& t : texts_) {
    if (t.index != index || subindex != 0) continue;
    if (t.capacity == 0) return 0x06010002;
    if (data.size() > t.capacity) return 0x06070012;
    t.value.assign(data.begin(), data.end());
    return 0;
  }
  Entry* e = find(index, subindex);
  if (e == nullptr) return whyMissing(index);
  if (!e->writable) return 0x06010002;
  if (data.size() > e->size) return 0x06070012;
  if (data.size() < e->size) return 0x06070013;
  std::int64_t value = 0;
  for (std::size_t i = data.size(); i-- > 0;) value = value << 8 | data[i];
  if (e->is_signed && holds(data.back(), 0x80)) value -= std::int64_t{1} << (8 * e->size);
  if (value > e->max) return 0x06090031;
  if (value < e->min) return 0x06090032;
  if (check_) {
    const std::uint32_t code = check_(index, subindex, value);
    if (code != 0) return code;
  }
  e->value = value;
  if (written_) written_(index, subindex);
  return 0;
}

// --- Server ---

bool SimulatedSdoServer::serve(const CanFrame& request, CanFrame& reply) {
  if (request.size != 8) return false;
  reply = CanFrame{};
  const unsigned command = request.data[0] >> 5;
  if (command == 4) {
    reset();
    return false;
  }
  reply.id = 0x580u + node_;
  reply.size = 8;
  if (command == 1 || command == 2) {
    index_ = static_cast<std::uint16_t>(request.data[1] | request.data[2] << 8);
    subindex_ = request.data[3];
  }
  switch (command) {
    case 0:
      downloadSegment(request, reply);
      break;
    case 1:
      startDownload(request, reply);
      break;
    case 2:
      startUpload(reply);
      break;
    case 3:
      uploadSegment(request, reply);
      break;
    default:
      abort(0x05040001, reply);
  }
  return true;
}

void SimulatedSdoServer::abort(std::uint32_t code, CanFrame& reply) {
  reset();
  reply.data = {0x80,
                static_cast<std::uint8_t>(index_),
                static_cast<std::uint8_t>(index_ >> 8),
                subindex_,
                static_cast<std::uint8_t>(code),
                static_cast<std::uint8_t>(code >> 8),
                static_cast<std::uint8_t>(code >> 16),
                static_cast<std::uint8_t>(code >> 24)};
}

void SimulatedSdoServer::startUpload(CanFrame& reply) {
  reset();
  const std::uint32_t code = dictionary_->read(index_, subindex_, data_);
  if (code != 0) return abort(code, reply);
  reply.data[1] = static_cast<std::uint8_t>(index_);
  reply.data[2] = static_cast<std::uint8_t>(index_ >> 8);
  reply.data[3] = subindex_;
  if (!data_.empty() && data_.size() <= 4) {
    reply.data[0] = static_cast<std::uint8_t>(0x43 | (4 - data_.size()) << 2);
    std::copy(data_.begin(), data_.end(), reply.data.begin() + 4);
    return;
  }
  reply.data[0] = 0x41;
  for (std::size_t i = 0; i < 4; ++i) reply.data[4 + i] = static_cast<std::uint8_t>(data_.size() >> (8 * i));
  transfer_ = Transfer::kUpload;
  offset_ = 0;
  toggle_ = false;
}

void SimulatedSdoServer::uploadSegment(const CanFrame& request, CanFrame& reply) {
  if (transfer_ != Transfer::kUpload) return abort(0x05040001, reply);
  if (holds(request.data[0], 0x10) != toggle_) return abort(0x05030000, reply);
  const std::size_t count = std::min<std::size_t>(7, data_.size() - offset_);
  const bool last = offset_ + count == data_.size();
  reply.data[0] = static_cast<std::uint8_t>((toggle_ ? 0x10u : 0u) | (7 - count) << 1 | (last ? 1u : 0u));
  std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(offset_), count, reply.data.begin() + 1);
  offset_ += count;
  toggle_ = !toggle_;
  if (last) reset();
}

void SimulatedSdoServer::startDownload(const CanFrame& request, CanFrame& reply) {
  reset();
  const std::uint8_t command = request.data[0];
  reply.data[0] = 0x60;
  std::copy_n(request.data.begin() + 1, 3, reply.data.begin() + 1);
  data_.clear();
  if (holds(command, 0x02)) {
    const std::size_t count = holds(command, 0x01) ? 4u - (command >> 2 & 3u) : 4u;
    data_.assign(request.data.begin() + 4, request.data.begin() + 4 + static_cast<std::ptrdiff_t>(count));
    const std::uint32_t code = dictionary_->write(index_, subindex_, data_);
    if (code != 0) abort(code, reply);
    return;
  }
  announced_ = 0;
  if (holds(command, 0x01))
    for (std::size_t i = 4; i-- > 0;) announced_ = announced_ << 8 | request.data[4 + i];
  if (announced_ > kMaxTransfer) return abort(0x05040005, reply);
  transfer_ = Transfer::kDownload;
  toggle_ = false;
}

void SimulatedSdoServer::downloadSegment(const CanFrame& request, CanFrame& reply) {
  const std::uint8_t command = request.data[0];
  if (transfer_ != Transfer::kDownload) return abort(0x05040001, reply);
  if (holds(command, 0x10) != toggle_) return abort(0x05030000, reply);
  const std::ptrdiff_t count = 7 - (command >> 1 & 7);
  data_.insert(data_.end(), request.data.begin() + 1, request.data.begin() + 1 + count);
  if (data_.size() > kMaxTransfer) return abort(0x05040005, reply);
  reply.data[0] = static_cast<std::uint8_t>(0x20 | (toggle_ ? 0x10 : 0));
  toggle_ = !toggle_;
  if (!holds(command, 0x01)) return;
  if (announced_ != 0 && announced_ != data_.size()) return abort(0x06070010, reply);
  reset();
  const std::uint32_t code = dictionary_->write(index_, subindex_, data_);
  if (code != 0) abort(code, reply);
}

}  // namespace sinew
