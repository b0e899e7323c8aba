#include "actuator_table.h"

#include <QScrollBar>

#include "tone_colours.h"

namespace sinew {
namespace {

enum Column { kName, kBar, kApplied, kMeasured, kEffort, kTemperature, kZero, kColumns };

constexpr struct {
  const char* title;
  const char* widest;  // what the column has to have room for
} kTitles[kColumns] = {{"Actuator", ""},        {"Range", ""},      {"Set", "-88.88 mm"}, {"Measured", "-88.88 mm"},
                       {"Effort", "888.8 kPa"}, {"Temp.", "88 °C"}, {"Zero", ""}};

QString text(const std::string& utf8) {
  return QString::fromStdString(utf8);
}

QLabel* makeLabel(QWidget* parent, Qt::Alignment alignment) {
  auto* label = new QLabel(parent);
  label->setTextFormat(Qt::PlainText);
  label->setAlignment(alignment | Qt::AlignVCenter);
  return label;
}

void setColour(QWidget* widget, Tone tone) {
  const QString style = tone == Tone::kPlain ? QString() : "color: " + fillColour(tone).name();
  if (widget->styleSheet() != style) widget->setStyleSheet(style);
}

void addTitles(QWidget* body, QGridLayout& grid) {
  for (int column = 0; column < kColumns; ++column) {
    auto* title = makeLabel(body, column <= kBar ? Qt::AlignLeft : Qt::AlignRight);
    title->setText(QString::fromUtf8(kTitles[column].title));
    setColour(title, Tone::kStale);
    grid.addWidget(title, 0, column);
    const QString widest = QString::fromUtf8(kTitles[column].widest);
    grid.setColumnMinimumWidth(column, title->fontMetrics().horizontalAdvance(widest));
  }
}

}  // namespace

ActuatorTable::ActuatorTable(QWidget* parent) : QScrollArea(parent) {
  setWidgetResizable(true);
  setFrameShape(QFrame::NoFrame);
  setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
}

void ActuatorTable::show(const std::vector<ActuatorRow>& rows) {
  if (rows.size() != rows_.size()) rebuild(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) fill(rows_[i], rows[i]);
}

void ActuatorTable::rebuild(std::size_t rows) {
  auto* body = new QWidget;
  auto* grid = new QGridLayout(body);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setHorizontalSpacing(8);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(kBar, 1);
  addTitles(body, *grid);
  rows_.clear();
  for (std::size_t i = 0; i < rows; ++i) rows_.push_back(makeRow(body, *grid, 1 + 2 * static_cast<int>(i)));
  grid->setRowStretch(1 + 2 * static_cast<int>(rows), 1);
  setWidget(body);  // deletes the one before
  setMinimumWidth(body->minimumSizeHint().width() + verticalScrollBar()->sizeHint().width());
}

ActuatorTable::Row ActuatorTable::makeRow(QWidget* body, QGridLayout& grid, int line) {
  Row row;
  const auto add = [&](int column, Qt::Alignment alignment) {
    auto* label = makeLabel(body, alignment);
    grid.addWidget(label, line, column);
    return label;
  };
  row.name = add(kName, Qt::AlignLeft);
  row.applied = add(kApplied, Qt::AlignRight);
  row.measured = add(kMeasured, Qt::AlignRight);
  row.effort = add(kEffort, Qt::AlignRight);
  row.temperature = add(kTemperature, Qt::AlignRight);
  row.zero = add(kZero, Qt::AlignRight);
  row.bar = new RangeBar(body);
  grid.addWidget(row.bar, line, kBar);
  row.faults = makeLabel(body, Qt::AlignLeft);
  row.faults->setWordWrap(true);
  row.faults->hide();
  grid.addWidget(row.faults, line + 1, kBar, 1, kColumns - kBar);
  return row;
}

void ActuatorTable::fill(const Row& row, const ActuatorRow& actuator) {
  row.name->setText(text(actuator.name));
  row.applied->setText(text(actuator.applied_text));
  row.measured->setText(text(actuator.measured_text));
  row.effort->setText(text(actuator.effort));
  row.temperature->setText(text(actuator.temperature));
  row.zero->setText(actuator.zero_valid ? "valid" : "lost");
  row.bar->show(actuator);
  row.bar->setToolTip(text(actuator.range));
  row.faults->setText(text(actuator.faults));
  row.faults->setVisible(!actuator.faults.empty());
  for (QLabel* label : {row.name, row.applied, row.measured, row.effort, row.temperature, row.faults})
    setColour(label, actuator.tone);
  setColour(row.zero, actuator.tone == Tone::kPlain && !actuator.zero_valid ? Tone::kCaution : actuator.tone);
}

}  // namespace sinew
