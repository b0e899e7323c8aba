#include "control_panel.h"

#include <ros/names.h>
#include <ros/node_handle.h>
#include <std_msgs/Bool.h>

#include <QTimer>
#include <QVBoxLayout>
#include <pluginlib/class_list_macros.hpp>

#include "tone_colours.h"

namespace sinew {
namespace {

constexpr int kRefreshPeriod = 100;  // ms
constexpr int kSpacing = 6;          // px
constexpr int kMinimumWidth = 484;   // px, of the columns of the actuators
constexpr int kBadgeWidth = 104;     // px, of a state in capitals
constexpr int kButtonHeight = 28;    // px
constexpr int kStopHeight = 60;      // px
const char* const kVerbTexts[kVerbs] = {"Init", "Recover", "Halt", "Enable", "Disable"};

QString text(const std::string& utf8) {
  return QString::fromStdString(utf8);
}

// A style sheet is costly to set, even the same one again.
void setSheet(QWidget* widget, const QString& style) {
  if (widget->styleSheet() != style) widget->setStyleSheet(style);
}

QString stopSheet(bool pressed) {
  const QString sheet("background: %1; color: %2; border: 3px solid %3; border-radius: 6px; font: bold 20px;");
  return pressed ? sheet.arg("#6e0d0d", "#ffd84a", "#ffd84a") : sheet.arg("#d81e1e", "white", "#8c1010");
}

void showBadge(QLabel* label, const PanelText& state) {
  label->setText(text(state.text));
  setSheet(label, "background: " + fillColour(state.tone).name() +
                      "; color: white; border-radius: 4px; padding: 3px; font-weight: bold;");
}

void showText(QLabel* label, const PanelText& content) {
  label->setText(text(content.text));
  label->setToolTip(text(content.text));
  setSheet(label, content.tone == Tone::kPlain ? QString() : "color: " + fillColour(content.tone).name());
}

QLabel* makeText(QWidget* parent, int lines) {
  auto* label = new QLabel(parent);
  label->setTextFormat(Qt::PlainText);
  label->setWordWrap(lines > 1);
  label->setFixedHeight(lines * label->fontMetrics().lineSpacing() + 2);
  label->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
  return label;
}

QLabel* makeBadge(QWidget* parent, const char* name) {
  auto* label = new QLabel(parent);
  label->setObjectName(name);
  label->setAlignment(Qt::AlignCenter);
  label->setFixedSize(kBadgeWidth, kButtonHeight);
  return label;
}

}  // namespace

ControlPanel::ControlPanel(QWidget* parent) : rviz::Panel(parent), spinner_(1, &queue_) {
  setMinimumWidth(kMinimumWidth);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(kSpacing, kSpacing, kSpacing, kSpacing);
  column->setSpacing(kSpacing);
  column->addLayout(makeStates());
  column->addLayout(makeButtons());
  makeStop();
  column->addWidget(stop_);
  answer_ = makeText(this, 2);
  column->addWidget(answer_);
  actuators_ = new ActuatorTable(this);
  column->addWidget(actuators_, 1);
  column->addLayout(makeNamespace());
}

ControlPanel::~ControlPanel() {
  spinner_.stop();
}

void ControlPanel::onInitialize() {
  connectTo("");
  spinner_.start();
  auto* timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, &ControlPanel::refresh);
  timer->start(kRefreshPeriod);
  refresh();
}

void ControlPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString name_space;
  if (config.mapGetString("Namespace", &name_space)) connectTo(name_space);
}

void ControlPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Namespace", connected_to_);
}

// --- What it is made of ---

QLayout* ControlPanel::makeStates() {
  auto* grid = new QGridLayout;
  grid->setSpacing(kSpacing);
  grid->setColumnStretch(2, 1);
  const auto addRow = [&](int row, const char* title, QWidget* state, QWidget* content) {
    grid->addWidget(new QLabel(title, this), row, 0);
    if (state) grid->addWidget(state, row, 1);
    grid->addWidget(content, row, state ? 2 : 1, 1, state ? 1 : 2);
  };
  driver_ = makeBadge(this, "Driver");
  controller_ = makeBadge(this, "Controller");
  driver_reason_ = makeText(this, 3);
  controller_reason_ = makeText(this, 3);
  cycle_ = makeText(this, 1);
  counters_ = makeText(this, 1);
  addRow(0, "Driver", driver_, driver_reason_);
  addRow(1, "Controller", controller_, controller_reason_);
  addRow(2, "Cycle", nullptr, cycle_);
  addRow(3, "Counters", nullptr, counters_);
  return grid;
}

QLayout* ControlPanel::makeButtons() {
  auto* row = new QHBoxLayout;
  row->setSpacing(kSpacing);
  for (std::size_t i = 0; i < kVerbs; ++i) {
    auto* button = new QPushButton(kVerbTexts[i], this);
    button->setObjectName(kVerbTexts[i]);
    button->setFixedHeight(kButtonHeight);
    button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
    connect(button, &QPushButton::clicked, this, [this, i] { ask(static_cast<Verb>(i)); });
    row->addWidget(button, 1);
    buttons_[i] = button;
  }
  return row;
}

void ControlPanel::makeStop() {
  stop_ = new QPushButton(this);
  stop_->setObjectName("EmergencyStop");
  stop_->setFixedHeight(kStopHeight);
  connect(stop_, &QPushButton::pressed, this, [this] {
    stop_by_this_press_ = !stop_pressed_;
    if (stop_by_this_press_) setStop(true);
  });
  connect(stop_, &QPushButton::clicked, this, [this] {
    if (!stop_by_this_press_) setStop(false);
  });
}

QLayout* ControlPanel::makeNamespace() {
  auto* row = new QHBoxLayout;
  row->setSpacing(kSpacing);
  namespace_ = new QLineEdit(this);
  namespace_->setObjectName("Namespace");
  connect(namespace_, &QLineEdit::editingFinished, this, [this] {
    if (namespace_->text() == connected_to_) return;
    connectTo(namespace_->text());
    Q_EMIT configChanged();
  });
  row->addWidget(new QLabel("Namespace", this));
  row->addWidget(namespace_, 1);
  return row;
}

// --- What it does ---

std::string ControlPanel::resolve(Verb verb) const {
  return base_ + "/" + serviceOf(verb);
}

void ControlPanel::connectTo(const QString& name_space) {
  std::string error;
  if (!ros::names::validate(name_space.toStdString(), error)) {
    showText(answer_, {"no namespace: " + error, Tone::kBad});
    namespace_->setText(connected_to_);
    return;
  }
  connected_to_ = name_space;
  namespace_->setText(name_space);
  ros::NodeHandle node(name_space.toStdString());
  node.setCallbackQueue(&queue_);
  base_ = node.getNamespace() == "/" ? "" : node.getNamespace();
  namespace_->setPlaceholderText(text(node.getNamespace()) + ", that of rviz");
  emergency_stop_ = node.advertise<std_msgs::Bool>("emergency_stop", 1, true);
  actuator_state_.subscribe(node, "actuator_state");
  controller_state_.subscribe(node, "controller_state");
}

void ControlPanel::ask(Verb verb) {
  calls_.start(resolve(verb));
  showText(answer_, {resolve(verb) + " ...", Tone::kPlain});
}

void ControlPanel::setStop(bool pressed) {
  stop_pressed_ = pressed;
  std_msgs::Bool message;
  message.data = pressed;
  emergency_stop_.publish(message);
  namespace_->setEnabled(!pressed);  // the stop belongs to the robot at which it was pressed
  refresh();
}

void ControlPanel::refresh() {
  const PanelView view = calcPanelView(actuator_state_.newest(), controller_state_.newest(), stop_pressed_);
  showBadge(driver_, view.driver);
  showText(driver_reason_, view.driver_reason);
  showBadge(controller_, view.controller);
  showText(controller_reason_, view.controller_reason);
  showText(cycle_, view.cycle);
  showText(counters_, view.counters);
  stop_->setText(text(view.stop.text));
  setSheet(stop_, stopSheet(stop_pressed_));
  actuators_->show(view.actuators);
  showButtons(view);
  showAnswers();
}

void ControlPanel::showButtons(const PanelView& view) {
  for (std::size_t i = 0; i < kVerbs; ++i) {
    const bool under_way = calls_.underWay(resolve(static_cast<Verb>(i)));
    buttons_[i]->setEnabled(view.possible[i] && !under_way);
  }
}

void ControlPanel::showAnswers() {
  for (const ServiceAnswer& answer : calls_.takeAnswers())
    showText(answer_, {answer.service + ": " + answer.message, answer.success ? Tone::kGood : Tone::kBad});
}

}  // namespace sinew

PLUGINLIB_EXPORT_CLASS(sinew::ControlPanel, rviz::Panel)
