#pragma once

#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A text table: a line of column names first, then one line a row, cells separated by commas. Cells stay text until a
/// column is asked for as numbers. Every complaint is a ConfigError that gives file, line and column.
class CsvTable {
 public:
  static CsvTable fromFile(const std::string& path);
  static CsvTable fromText(const std::string& text, const std::string& name);

  const std::string& name() const { return name_; }
  const std::vector<std::string>& columns() const { return columns_; }
  int rows() const { return static_cast<int>(rows_.size()); }
  bool has(const std::string& column) const { return find(column) >= 0; }

  /// Every row of a column, each finite.
  VecX numbers(const std::string& column) const;
  /// Likewise, each greater than the one before.
  VecX risingNumbers(const std::string& column) const;

 private:
  struct Row {
    int line;
    std::vector<std::string> cells;
  };

  explicit CsvTable(const std::string& name) : name_(name) {}
  void readColumns(const std::string& line);
  void readRow(const std::string& line, int number);
  int find(const std::string& column) const;
  std::string placeOf(int row, const std::string& column) const;

  std::string name_;
  std::vector<std::string> columns_;
  std::vector<Row> rows_;
};

}  // namespace sinew
