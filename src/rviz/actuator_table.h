#pragma once

#include <QGridLayout>
#include <QLabel>
#include <QScrollArea>
#include <vector>

#include "panel_model.h"
#include "range_bar.h"

namespace sinew {

/// A row per actuator: its bar, numbers in aligned columns, and below them in words what is wrong with it.
class ActuatorTable : public QScrollArea {
 public:
  explicit ActuatorTable(QWidget* parent = nullptr);

  void show(const std::vector<ActuatorRow>& rows);

 private:
  struct Row {
    QLabel *name, *applied, *measured, *effort, *temperature, *zero, *faults;
    RangeBar* bar;
  };

  void rebuild(std::size_t rows);
  Row makeRow(QWidget* body, QGridLayout& grid, int line);
  static void fill(const Row& row, const ActuatorRow& actuator);

  std::vector<Row> rows_;
};

}  // namespace sinew
