#include "sinew/hardware/answer_queue.h"

#include <algorithm>
#include <array>

namespace sinew {
namespace {

constexpr double kBitsPerByte = 10;  // start, 8 data, stop

}  // namespace

Duration AnswerQueue::lineTime(std::size_t bytes) const {
  return duration(kBitsPerByte * static_cast<double>(bytes) / baud_);
}

Time AnswerQueue::occupy(std::size_t bytes, Time start) {
  line_free_ = std::max(line_free_, start) + lineTime(bytes);
  return line_free_;
}

void AnswerQueue::setFaults(const LineFaults& faults) {
  faults_ = faults;
  random_.seed(faults.seed);
}

// One to three different bits.
void AnswerQueue::corrupt(Bytes& frame) {
  std::uniform_int_distribution<std::size_t> bit(0, 8 * frame.size() - 1);
  std::array<std::size_t, 3> flipped{};
  const std::size_t count = std::uniform_int_distribution<std::size_t>(1, 3)(random_);
  for (std::size_t n = 0; n < count;) {
    const std::size_t b = bit(random_);
    if (std::find(flipped.begin(), flipped.begin() + static_cast<std::ptrdiff_t>(n), b) !=
        flipped.begin() + static_cast<std::ptrdiff_t>(n))
      continue;
    flipped[n++] = b;
    frame[b / 8] = static_cast<std::uint8_t>(frame[b / 8] ^ (1u << b % 8));
  }
}

void AnswerQueue::insert(Bytes frame, Time due) {
  const auto later = [](Time t, const Frame& f) { return t < f.due; };
  frames_.insert(std::upper_bound(frames_.begin(), frames_.end(), due, later), Frame{due, std::move(frame)});
}

void AnswerQueue::send(Bytes frame, Time ready) {
  Time due = occupy(frame.size(), ready);
  double u = std::uniform_real_distribution<double>(0, 1)(random_);
  const auto picks = [&u](double share) { return (u -= share) < 0; };
  if (picks(faults_.corrupt)) {
    ++counts_.corrupted;
    corrupt(frame);
  } else if (picks(faults_.drop)) {
    ++counts_.dropped;
    return;
  } else if (picks(faults_.delay)) {
    ++counts_.delayed;
    due += duration(faults_.delay_time);
  } else if (picks(faults_.duplicate)) {
    ++counts_.duplicated;
    insert(frame, due);
    due = occupy(frame.size(), due);
  } else {
    ++counts_.sent;
  }
  insert(std::move(frame), due);
}

std::size_t AnswerQueue::transmit(std::uint8_t* data, std::size_t capacity, Time now) {
  std::size_t count = 0;
  while (!frames_.empty() && frames_.front().due <= now && frames_.front().bytes.size() <= capacity - count) {
    const Bytes& bytes = frames_.front().bytes;
    std::copy(bytes.begin(), bytes.end(), data + count);
    count += bytes.size();
    frames_.pop_front();
  }
  return count;
}

}  // namespace sinew
