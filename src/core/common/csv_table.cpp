#include "sinew/common/csv_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr char kBlank[] = " \t\r";
constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";

bool isBlank(const std::string& line) {
  return line.find_first_not_of(kBlank) == std::string::npos;
}

std::string trim(const std::string& text) {
  if (isBlank(text)) return "";
  const std::size_t first = text.find_first_not_of(kBlank);
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string> splitCells(const std::string& line) {
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos; comma = line.find(',', begin)) {
    cells.push_back(trim(line.substr(begin, comma - begin)));
    begin = comma + 1;
  }
  cells.push_back(trim(line.substr(begin)));
  return cells;
}

}  // namespace

CsvTable CsvTable::fromFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw ConfigError(path, "no readable text", "a table with a line of names");
  return fromText(text.str(), path);
}

CsvTable CsvTable::fromText(const std::string& text, const std::string& name) {
  CsvTable table(name);
  std::istringstream lines(text.compare(0, 3, kByteOrderMark) == 0 ? text.substr(3) : text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (isBlank(line)) continue;
    table.columns_.empty() ? table.readColumns(line) : table.readRow(line, number);
  }
  if (table.columns_.empty()) throw ConfigError(name, "nothing", "a line of column names");
  if (table.rows_.empty()) throw ConfigError(name, "no row", "at least one row below the column names");
  return table;
}

void CsvTable::readColumns(const std::string& line) {
  columns_ = splitCells(line);
  for (auto column = columns_.begin(); column != columns_.end(); ++column) {
    if (column->empty()) throw ConfigError(name_, "a column without a name", "one name for each column");
    if (std::find(columns_.begin(), column, *column) != column) {
      throw ConfigError(name_, "column " + *column + " twice", "each column once");
    }
  }
}

void CsvTable::readRow(const std::string& line, int number) {
  rows_.push_back({number, splitCells(line)});
  if (rows_.back().cells.size() != columns_.size()) {
    throw ConfigError(name_ + ":" + std::to_string(number), std::to_string(rows_.back().cells.size()) + " cells",
                      std::to_string(columns_.size()) + ", one for each column");
  }
}

VecX CsvTable::numbers(const std::string& column) const {
  const int index = find(column);
  if (index < 0) throw ConfigError(name_, "no column " + column, "one of that name");
  VecX values(rows());
  for (int row = 0; row < rows(); ++row) {
    const std::string& cell = rows_[static_cast<std::size_t>(row)].cells[static_cast<std::size_t>(index)];
    char* end = nullptr;
    values[row] = std::strtod(cell.c_str(), &end);
    if (cell.empty() || *end != '\0' || !std::isfinite(values[row])) {
      throw ConfigError(placeOf(row, column), cell.empty() ? "nothing" : cell, "a finite number");
    }
  }
  return values;
}

VecX CsvTable::risingNumbers(const std::string& column) const {
  VecX values = numbers(column);
  for (int row = 1; row < rows(); ++row) {
    if (values[row] > values[row - 1]) continue;
    std::ostringstream found;
    found << values[row] << " after " << values[row - 1];
    throw ConfigError(placeOf(row, column), found.str(), "a number greater than the one before");
  }
  return values;
}

int CsvTable::find(const std::string& column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  return found == columns_.end() ? -1 : static_cast<int>(found - columns_.begin());
}

std::string CsvTable::placeOf(int row, const std::string& column) const {
  return name_ + ":" + std::to_string(rows_[static_cast<std::size_t>(row)].line) + ": " + column;
}

}  // namespace sinew
