#include "range_bar.h"

#include <QPainter>
#include <algorithm>
#include <cmath>

#include "tone_colours.h"

namespace sinew {
namespace {

constexpr double kRadius = 2;     // px, of corners
constexpr double kMark = 2;       // px, width of the mark
constexpr double kGrooveTop = 3;  // px
const QColor kMeasured(64, 128, 192);

QColor barColour(Tone tone) {
  return tone == Tone::kPlain ? kMeasured : fillColour(tone);
}

}  // namespace

RangeBar::RangeBar(QWidget* parent) : QWidget(parent) {
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
}

void RangeBar::show(const ActuatorRow& row) {
  low_ = row.low;
  high_ = row.high;
  applied_ = row.applied;
  measured_ = row.measured;
  tone_ = row.tone;
  update();
}

double RangeBar::xOf(double value) const {
  const double share = (value - low_) / (high_ - low_);
  return kMark / 2 + std::min(std::max(share, 0.0), 1.0) * (width() - kMark);
}

void RangeBar::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  const QRectF groove(0.5, kGrooveTop, width() - 1.0, height() - 2 * kGrooveTop);
  painter.setPen(palette().color(QPalette::Mid));
  painter.setBrush(palette().color(QPalette::Base));
  painter.drawRoundedRect(groove, kRadius, kRadius);
  if (!(high_ > low_)) return;

  const double zero = xOf(0);
  painter.setPen(Qt::NoPen);
  if (std::isfinite(measured_)) {
    const double x = xOf(measured_);
    painter.setBrush(barColour(tone_));
    painter.drawRect(
        QRectF(QPointF(std::min(zero, x), groove.top() + 1), QPointF(std::max(zero, x), groove.bottom() - 1)));
  }
  painter.fillRect(QRectF(zero - 0.5, groove.top(), 1, groove.height()), palette().color(QPalette::Dark));
  if (std::isfinite(applied_))
    painter.fillRect(QRectF(xOf(applied_) - kMark / 2, 0, kMark, height()), palette().color(QPalette::WindowText));
}

}  // namespace sinew
