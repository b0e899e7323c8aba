// Replays the kept inputs of a fuzzer, and some thousand small changes to them. The entry point aborts when a property
// does not hold.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "hardware/check_line.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kChanges = 20;  // of every input

/// In the order of their names, so that a failure comes again.
std::vector<Bytes> readCorpus() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(SINEW_CORPUS)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Bytes> inputs;
  for (const auto& path : paths) {
    std::ifstream file(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return inputs;
}

void replay(const Bytes& input) {
  ASSERT_EQ(LLVMFuzzerTestOneInput(input.data(), input.size()), 0);
}

Bytes change(Bytes input, std::mt19937& random) {
  if (input.empty()) return input;
  const std::size_t at = random() % input.size();
  switch (random() % 3) {
    case 0:
      input[at] = static_cast<std::uint8_t>(random());
      break;
    case 1:
      input[at] = static_cast<std::uint8_t>(input[at] ^ (1u << random() % 8));
      break;
    default:
      input.resize(at);
  }
  return input;
}

TEST(FuzzCorpus, HoldsForEveryKeptInput) {
  const std::vector<Bytes> inputs = readCorpus();
  for (const Bytes& input : inputs) replay(input);
  checkAtLeast("fuzz_corpus." SINEW_DECODER, static_cast<double>(inputs.size()), 5, "1");
}

TEST(FuzzCorpus, HoldsForInputsNearTheKeptOnes) {
  std::mt19937 random(1);
  for (const Bytes& input : readCorpus())
    for (int n = 0; n < kChanges; ++n) replay(change(input, random));
}

}  // namespace
}  // namespace sinew
