#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "sinew/hardware/actuator_reading.h"

namespace sinew {

/// The command line is wrong; the message says what would be right.
class WrongUse : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Numbers with units as a person types them, in SI units: "5mm", "-0.5 cm", "10kPa", "2mm/s", "3N". Each throws
// WrongUse, naming `what`, when the unit is missing or of another quantity.

/// m for a displacement, Pa for a pressure.
double parseDistance(const std::string& text, Quantity quantity, const std::string& what);
/// m/s or Pa/s.
double parseSpeed(const std::string& text, Quantity quantity, const std::string& what);
/// N.
double parseForce(const std::string& text, const std::string& what);

/// "1.20 mm", "3.4 kPa".
std::string formatDistance(double distance, Quantity quantity);
/// "2.1 N", "3.4 kPa".
std::string formatEffort(double effort, Quantity quantity);

/// Says what is going to be done, and asks at the terminal whether it may be, unless `yes` has said so. Throws WrongUse
/// when nobody can be asked.
bool isAllowed(const std::string& deed, bool yes);

/// Heading and rows of the table of readings, `width` columns for names.
/// Columns that the longest of `names` needs.
int calcWidth(const std::vector<std::string>& names);
std::string makeReadingHeader(int width);
std::string makeReadingRow(const std::string& name, int width, Quantity quantity, const ActuatorReading& reading);

}  // namespace sinew
