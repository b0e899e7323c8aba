#include "sinew/hardware/servo_models.h"

#include <algorithm>
#include <iterator>
#include <string>

namespace sinew {
namespace {

// ROBOTIS e-Manual, DYNAMIXEL X: "Control Table of EEPROM Area" and "RAM Area" of each model.
constexpr ServoModel kModels[] = {
    {1000, "XH430-W350", 2.69e-3, 9.5, 168, 224},  {1010, "XH430-W210", 2.69e-3, 9.5, 168, 224},
    {1020, "XM430-W350", 2.69e-3, 9.5, 168, 224},  {1030, "XM430-W210", 2.69e-3, 9.5, 168, 224},
    {1040, "XH430-V350", 1.34e-3, 11.0, 168, 224}, {1050, "XH430-V210", 1.34e-3, 11.0, 168, 224},
    {1100, "XH540-W270", 2.69e-3, 9.5, 168, 224},  {1110, "XH540-W150", 2.69e-3, 9.5, 168, 224},
    {1120, "XM540-W270", 2.69e-3, 9.5, 168, 224},  {1130, "XM540-W150", 2.69e-3, 9.5, 168, 224},
    {1140, "XH540-V270", 2.69e-3, 11.0, 168, 224}, {1150, "XH540-V150", 2.69e-3, 11.0, 168, 224},
    {1190, "XL330-M077", 1.0e-3, 3.5, 168, 208},   {1200, "XL330-M288", 1.0e-3, 3.5, 168, 208},
    {1210, "XC330-T181", 1.0e-3, 5.5, 168, 208},   {1220, "XC330-T288", 1.0e-3, 5.5, 168, 208},
    {1230, "XC330-M181", 1.0e-3, 3.5, 168, 208},   {1240, "XC330-M288", 1.0e-3, 3.5, 168, 208},
};

std::string makeList() {
  std::string text;
  for (const ServoModel& m : kModels) text += (text.empty() ? "" : ", ") + std::to_string(m.number) + " " + m.name;
  return text;
}

}  // namespace

const ServoModel* findServoModel(std::uint16_t number) {
  const auto* const found =
      std::find_if(std::begin(kModels), std::end(kModels), [&](const ServoModel& m) { return m.number == number; });
  return found == std::end(kModels) ? nullptr : found;
}

const char* listServoModels() {
  static const std::string text = makeList();
  return text.c_str();
}

}  // namespace sinew
