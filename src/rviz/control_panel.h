#pragma once

#include <ros/callback_queue.h>
#include <ros/publisher.h>
#include <ros/spinner.h>
#include <rviz/panel.h>

#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <array>

#include "actuator_table.h"
#include "message_inbox.h"
#include "panel_model.h"
#include "service_calls.h"

namespace sinew {

/// One robot in rviz: the states of driver and controller, what can be asked of them, every actuator, and an emergency
/// stop. The stop acts when it is pressed down, stays, and is let go by another click.
class ControlPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit ControlPanel(QWidget* parent = nullptr);
  ~ControlPanel() override;

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  void connectTo(const QString& name_space);
  std::string resolve(Verb verb) const;
  void ask(Verb verb);
  void setStop(bool pressed);
  void refresh();
  void showAnswers();
  void showButtons(const PanelView& view);

  QLayout* makeStates();
  QLayout* makeButtons();
  void makeStop();
  QLayout* makeNamespace();

  QLabel *driver_, *driver_reason_, *controller_, *controller_reason_, *cycle_, *counters_, *answer_;
  std::array<QPushButton*, kVerbs> buttons_{};
  QPushButton* stop_;
  ActuatorTable* actuators_;
  QLineEdit* namespace_;

  bool stop_pressed_ = false;
  bool stop_by_this_press_ = false;  // so that letting go of the mouse does not let go of the stop
  QString connected_to_;             // text of namespace_ that was valid
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;
  std::string base_;  // resolved namespace
  ros::Publisher emergency_stop_;
  MessageInbox<ActuatorState> actuator_state_;
  MessageInbox<ControllerState> controller_state_;
  ServiceCalls calls_;
};

}  // namespace sinew
