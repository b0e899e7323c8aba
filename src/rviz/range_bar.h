#pragma once

#include <QWidget>

#include "panel_model.h"

namespace sinew {

/// One actuator within its limits: a bar from zero to what is measured, and a mark at what is applied.
class RangeBar : public QWidget {
 public:
  explicit RangeBar(QWidget* parent = nullptr);

  void show(const ActuatorRow& row);

  QSize sizeHint() const override { return {96, 16}; }
  QSize minimumSizeHint() const override { return {64, 16}; }

 protected:
  void paintEvent(QPaintEvent*) override;

 private:
  double xOf(double value) const;  // px, at the nearer end when outside the limits

  double low_ = 0, high_ = 0, applied_ = 0, measured_ = 0;
  Tone tone_ = Tone::kStale;
};

}  // namespace sinew
