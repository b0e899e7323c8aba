// `rosrun sinew bus` as a user calls it, on simulated devices of every kind.

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "sinew/hardware/pseudo_terminal.h"
#include "sinew/hardware/simulated_hardware.h"

namespace sinew {
namespace {

constexpr double kStep = 0.002;     // s of the mechanics
constexpr double kStiffness = 400;  // N/m of the robot at each cable
constexpr double kPretension = 1;   // N

// Patient, so that a busy machine makes no device seem silent. `more` are more actuators.
std::string makeYaml(const std::string& folder, const std::string& more = "") {
  const std::string cable =
      "spool_radius: 0.01, sign: 1, displacement_min: -0.03, displacement_max: 0.06, rate_max: 0.04, tension_max: 20,"
      " on_timeout: relax, homing: ";
  const std::string patience = "reply_timeout: 0.3, missing_limit: 1000}\n";
  return "hardware:\n  buses:\n"
         "    - {name: servos, protocol: dynamixel2, baud: 1000000, port: " +
         folder + "/line_servos, " + patience +
         "    - {name: drives, protocol: can, bitrate: 1000000, port: " + folder + "/line_drives, " + patience +
         "    - {name: air, protocol: pressure_board, baud: 1000000, port: " + folder + "/line_air, " + patience +
         "  rate: 50\n  command_timeout: 5\n  hold_limit: 5\n  relax_time: 0.1\n  bus_watchdog: 2.5\n"
         "  servo: {torque_constant: 1.78, " +
         cable +
         "{method: tension, tension: 3, speed: 0.02, travel: 0.03}}\n"
         "  drive: {torque_constant: 0.5, counts_per_turn: 4096, gear: 10, " +
         cable +
         "{method: present}}\n"
         "  odrive: {torque_constant: 0.5, gear_ratio: 1, " +
         cable +
         "{method: present}}\n"
         "  pressure_channel: {id: 1, pressure_min: 0, pressure_max: 60000, pressure_limit: 70000, rate_max: 100000,"
         " on_timeout: vent}\n"
         "  actuators:\n"
         "    - {name: cable_1, bus: servos, id: 1}\n"
         "    - {name: cable_2, bus: servos, id: 2}\n"
         "    - {name: cable_3, bus: drives, device: canopen, id: 5}\n"
         "    - {name: cable_4, bus: drives, device: odrive, id: 6}\n"
         "    - {name: chamber_1, bus: air, channel: 0}\n" +
         more;
}

struct Answer {
  int code = -1;
  std::string words;
};

Answer run(const std::string& arguments, const std::string& in = "/dev/null") {
  Answer answer;
  FILE* const pipe = popen((SINEW_BUS " " + arguments + " 2>&1 <" + in).c_str(), "r");
  std::array<char, 256> line;
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) answer.words += line.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) answer.code = WEXITSTATUS(status);
  return answer;
}

void expectWords(const Answer& answer, const std::vector<std::string>& all) {
  for (const std::string& words : all)
    EXPECT_NE(answer.words.find(words), std::string::npos) << "'" << words << "' in\n" << answer.words;
}

/// Simulated devices on lines of their own, and what they did since the beginning.
class Bus : public testing::Test {
 protected:
  Bus()
      : folder_(makeFolder()),
        file(write("hardware.yaml", makeYaml(folder_))),
        hardware(HardwareDescription::load(file)),
        reach_(static_cast<std::size_t>(hardware.size())),
        energised_(static_cast<std::size_t>(hardware.size())) {
    setenv("ROS_HOME", folder_.c_str(), 1);  // where zeros are kept
    for (int bus = 0; bus < hardware.buses(); ++bus) hardware.connect(bus);
    thread_ = std::thread([this] { move(); });
  }
  ~Bus() override {
    running_ = false;
    thread_.join();
    for (const std::string& path : written_) std::remove(path.c_str());
    for (int bus = 0; bus < hardware.buses(); ++bus) hardware.disconnect(bus);
    rmdir(folder_.c_str());
  }

  std::string path(const std::string& name) {
    written_.push_back(folder_ + "/" + name);
    return written_.back();
  }
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(path(name)) << text;
    return written_.back();
  }

  /// The farthest that a cable was reeled in [m], or the highest pressure of a channel [Pa].
  double reach(int i) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return reach_[static_cast<std::size_t>(i)];
  }
  /// Whether it was ever switched on.
  bool wasEnergised(int i) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return energised_[static_cast<std::size_t>(i)];
  }
  bool anyEnergised() {
    bool any = false;
    for (int i = 0; i < 4; ++i) any = any || hardware.energised(i);
    return any;
  }

 private:
  static std::string makeFolder() {
    std::string name = "/tmp/bus_test_XXXXXX";
    return mkdtemp(&name[0]);
  }

  void move() {
    while (running_) {
      for (int i = 0; i < 4; ++i) hardware.setTension(i, std::max(0., kPretension + kStiffness * hardware.reeledIn(i)));
      hardware.step(kStep);
      look();
      std::this_thread::sleep_for(std::chrono::duration<double>(kStep));
    }
  }

  void look() {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (int i = 0; i < hardware.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      reach_[k] = std::max(reach_[k], i < 4 ? hardware.reeledIn(i) : hardware.pressure(i));
      energised_[k] = energised_[k] || hardware.energised(i);
    }
  }

  std::vector<std::string> written_;
  std::string folder_;

 protected:
  std::string file;
  SimulatedHardware hardware;

 private:
  std::mutex mutex_;
  std::vector<double> reach_;
  std::vector<bool> energised_;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

TEST_F(Bus, scanFindsWhatTheFileExpects) {
  const Answer answer = run("scan " + file + " --ids 1-6");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"XM430-W350 (model 1020)", "cable_2", "CANopen drive", "vendor 0x", "ODrive axis", "idle",
                       "pressure board", "4 channels", "chamber_1", "all devices of the file answer"});
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(wasEnergised(i)) << "a search switches nothing on";
}

TEST_F(Bus, scanSaysWhatIsMissingAndWhatIsUnexpected) {
  std::string text = makeYaml(file.substr(0, file.rfind('/')), "    - {name: cable_9, bus: servos, id: 9}\n");
  text.replace(text.find("id: 2}"), 6, "id: 7}");
  const Answer answer = run("scan " + write("other.yaml", text) + " --ids 1-9 --seconds 0.2");
  EXPECT_EQ(answer.code, 1) << answer.words;
  expectWords(answer, {"missing: servo 7 (cable_2)", "missing: servo 9 (cable_9)", "unexpected", "not everything"});
}

TEST_F(Bus, scanNeedsNoFile) {
  const Answer servos = run("scan --protocol dynamixel2 --ids 1-2 --port " + hardware.port(0));
  EXPECT_EQ(servos.code, 0) << servos.words;
  expectWords(servos, {"2 found", "servo", "firmware"});
  const Answer boards = run("scan --protocol pressure_board --ids 1-1 --port " + hardware.port(2));
  EXPECT_EQ(boards.code, 0) << boards.words;
  expectWords(boards, {"1 found", "serial number"});
  const Answer none = run("scan --protocol dynamixel2 --ids 3 --port " + hardware.port(0));
  EXPECT_EQ(none.code, 1) << none.words;
  expectWords(none, {"no device answers"});
}

TEST_F(Bus, scanOnlyListensWhenToldTo) {
  const Answer answer = run("scan --protocol can --listen --port " + hardware.port(1));
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"ODrive axis", "heartbeats a second"});
  EXPECT_EQ(answer.words.find("CANopen"), std::string::npos) << "it is silent until it is asked\n" << answer.words;
}

TEST_F(Bus, watchShowsEveryDeviceAndLetsGo) {
  const Answer answer = run("watch " + file + " --yes --seconds 0.6");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"measured", "cable_1", "cable_4", "chamber_1", "kPa", "degC", "is well", "ready", "letting go"});
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(wasEnergised(i));
    EXPECT_LT(reach(i), 1e-3) << "nothing moves";
  }
  EXPECT_FALSE(anyEnergised());
}

TEST_F(Bus, aDeviceThatIsNotWellIsNamed) {
  hardware.setTemperature(0, 95);
  const Answer answer = run("watch " + file + " --yes --seconds 60");
  EXPECT_EQ(answer.code, 1) << answer.words;
  expectWords(answer, {"fault", "cable_1"});
  EXPECT_FALSE(anyEnergised());
}

TEST_F(Bus, aStopLetsGoFirst) {
  std::array<char, 4096> words{};
  FILE* const pipe = popen(("timeout -s INT 4 " SINEW_BUS " watch " + file + " --yes").c_str(), "r");
  while (std::fgets(words.data(), static_cast<int>(words.size()), pipe) != nullptr) {
  }
  pclose(pipe);
  EXPECT_EQ(std::string(words.data()), "letting go\n") << "the last line";
  EXPECT_FALSE(anyEnergised());
}

TEST_F(Bus, jogMovesOneCableThereAndBack) {
  const Answer answer = run("jog " + file + " cable_1 5mm --speed 20mm/s --yes");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer,
              {"cable_1 goes by 5.00 mm at 20.00 mm/s", "measured", "effort", "cable_1 moved by", "is back at"});
  EXPECT_NEAR(reach(0), 0.005, 5e-4);
  EXPECT_FALSE(anyEnergised());
  for (int i = 1; i < 4; ++i) EXPECT_FALSE(wasEnergised(i)) << "every other stays off";
}

TEST_F(Bus, jogRaisesAPressure) {
  const Answer answer = run("jog " + file + " chamber_1 10kPa --speed 20kPa/s --pressure 20kPa --yes");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"chamber_1 moved by", "kPa"});
  EXPECT_NEAR(reach(4), 1e4, 2e3);
}

TEST_F(Bus, jogOfACableTooWeakSaysSo) {
  const Answer answer = run("jog " + file + " cable_1 20mm --speed 40mm/s --tension 3N --yes");
  EXPECT_EQ(answer.code, 1) << answer.words;
  expectWords(answer, {"did not get where it was told"});
  EXPECT_LT(reach(0), 0.015) << "3 N reel in no more than about 5 mm";
}

TEST_F(Bus, zeroHomesAndWritesWhatIsCounted) {
  const std::string zeros = path("zeros.yaml");
  const Answer answer = run("zero " + file + " --yes --file " + zeros);
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"reeled in until taut", "counts", "written to " + zeros});
  EXPECT_GT(kPretension + kStiffness * reach(0), 2.) << "reeled in until about 3 N";
  std::ifstream written(zeros);
  std::stringstream text;
  text << written.rdbuf();
  EXPECT_NE(text.str().find("cable_1: "), std::string::npos) << text.str();
}

TEST_F(Bus, zerosOfBeforeAreForgottenBeforeAnythingIsSetUp) {
  const std::string own = write("sinew_zeros_hardware_driver.yaml", "cable_1: 12\ncable_2: 30\n");
  const std::string strange = write("sinew_zeros_other.yaml", "finger_1: 12\n");
  run("scan --protocol dynamixel2 --ids 1 --port " + hardware.port(0));
  EXPECT_TRUE(std::ifstream(own)) << "a search sets nothing up";
  const Answer answer = run("jog " + file + " cable_1 2mm --speed 20mm/s --yes");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {own + " is removed"});
  EXPECT_FALSE(std::ifstream(own));
  EXPECT_TRUE(std::ifstream(strange)) << "another robot's";
}

TEST_F(Bus, nothingGoesOnWhileTheEmergencyStopIsPressed) {
  std::string text = makeYaml(file.substr(0, file.rfind('/')));
  text.replace(text.find("  rate:"), 0, "  emergency_stop: {input: /dev/input/nowhere}\n");
  const std::string stopped = write("stopped.yaml", text);
  for (const std::string& verb : {"jog " + stopped + " cable_1 5mm", "watch " + stopped, "latency " + stopped}) {
    const Answer answer = run(verb + " --yes");
    EXPECT_EQ(answer.code, 1) << verb;
    expectWords(answer, {"the emergency stop is pressed"});
  }
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(wasEnergised(i));
}

TEST_F(Bus, latencyTellsTimesAndTheRate) {
  const Answer answer = run("latency " + file + " --cycles 20 --yes");
  EXPECT_EQ(answer.code, 0) << answer.words;
  expectWords(answer, {"bus servos", "bus drives", "bus air", "20 times write and read", "99 %", "missing", "up to"});
  EXPECT_FALSE(anyEnergised());
}

TEST_F(Bus, nothingIsSwitchedOnWithoutAWord) {
  for (const std::string& verb : {"watch " + file, "jog " + file + " cable_1 5mm", "zero " + file, "latency " + file}) {
    const Answer answer = run(verb);
    EXPECT_EQ(answer.code, 2) << verb;
    expectWords(answer, {"--yes"});
  }
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(wasEnergised(i));
}

TEST_F(Bus, aTerminalIsAskedOnce) {
  for (const std::string said : {"n\n", "y\n"}) {
    PseudoTerminal terminal;
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(said.data());
    ASSERT_EQ(terminal.write(bytes, said.size(), std::chrono::seconds(5)).count, said.size());
    const Answer answer = run("jog " + file + " cable_1 2mm", terminal.path());
    EXPECT_EQ(answer.code, 0) << answer.words;
    expectWords(answer, {"Go on?"});
    EXPECT_EQ(wasEnergised(0), said == "y\n");
  }
}

TEST_F(Bus, wrongLinesAreRefused) {
  const std::vector<std::pair<std::string, std::string>> lines = {
      {"", "VERB is missing"},
      {"dance", "no verb"},
      {"scan", "--protocol"},
      {"scan --port /dev/null --protocol spi", "expected dynamixel2, can or pressure_board"},
      {"scan " + file + " --ids 5-1", "as in 1-20"},
      {"watch", "HARDWARE.yaml is missing"},
      {"watch " + file + " --seconds -1", "--seconds"},
      {"watch " + file + " --sideways", "--sideways"},
      {"jog " + file + " cable_1 --yes", "DISTANCE is missing"},
      {"jog " + file + " cable_1 5 --yes", "its unit (mm, cm, m), as in 5mm"},
      {"jog " + file + " cable_1 5kPa --yes", "its unit"},
      {"jog " + file + " chamber_1 5mm --yes", "kPa"},
      {"jog " + file + " cable_8 5mm --yes", "expected one of cable_1"},
      {"jog " + file + " cable_1 500mm --yes", "-30.00 mm to 60.00 mm"},
      {"jog " + file + " cable_1 5mm --speed 1m/s --yes", "rate_max"},
      {"jog " + file + " cable_1 5mm --tension 50N --yes", "tension_max"},
      {"zero " + file + " twice --yes", "too much"},
      {"latency " + file + " --cycles 0 --yes", "--cycles"}};
  for (const auto& line : lines) {
    const Answer answer = run(line.first);
    EXPECT_EQ(answer.code, 2) << line.first << "\n" << answer.words;
    expectWords(answer, {line.second, "see bus --help"});
  }
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(wasEnergised(i));
}

TEST(BusWords, aFileOrAPortThatIsNotThereIsNamed) {
  const Answer file = run("watch nowhere.yaml --yes");
  EXPECT_EQ(file.code, 1);
  expectWords(file, {"nowhere.yaml"});
  const Answer port = run("scan --port /dev/nowhere --protocol dynamixel2");
  EXPECT_EQ(port.code, 1);
  expectWords(port, {"cannot open /dev/nowhere", "plugged in"});
}

TEST(BusWords, helpIsThereForEveryVerb) {
  EXPECT_EQ(run("--help").code, 0);
  for (const std::string verb : {"scan", "watch", "jog", "zero", "latency"}) {
    const Answer answer = run(verb + " --help");
    EXPECT_EQ(answer.code, 0);
    expectWords(answer, {"usage: bus " + verb, "--port"});
  }
}

}  // namespace
}  // namespace sinew
