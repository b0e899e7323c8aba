// Draws the body, its cables, the effectors, the limits reached, obstacles and contacts, and lets the user drag the
// targets and, in simulation, the obstacles.

#include <ros/message_event.h>
#include <ros/ros.h>
#include <sinew/BodyState.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/transform_listener.h>

#include <exception>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "parameters.h"
#include "ros_conversions.h"
#include "sinew/robot/robot_description.h"
#include "visualization_node_drawing.h"
#include "visualization_node_handles.h"
#include "visualization_node_obstacle_handles.h"
#include "visualization_node_obstacles.h"

namespace sinew {
namespace {

constexpr double kStale = 1.0;            // s after which a message is drawn no more
constexpr double kTrailSpacing = 0.02;    // s between two points of a trail
constexpr double kHandleSize = 0.18;      // of the body's extent
constexpr double kTrailWidth = 0.004;     // of the body's extent
constexpr double kContactRadius = 0.006;  // of the body's extent
constexpr double kLongestForce = 0.5;     // of the body's extent
constexpr double kPlaneSize = 3;          // of the body's extent
constexpr double kDefaultReach = 0.45;    // radius of the default workspace, of the body's extent

const Colour kSilicone(0.98, 0.66, 0.48, 0.62);
const Colour kSiliconeEdges(0.45, 0.20, 0.12, 0.25);
const Colour kPlant(0.35, 0.55, 0.90, 0.20);
const Colour kTrailColour(0.10, 0.75, 0.35, 1.0);
const Colour kTargetTrailColour(0.98, 0.55, 0.05, 0.45);

struct Settings {
  double rate;            // Hz
  double trail_duration;  // s
  std::string world_frame;
  bool interactive;
  Workspace workspace;
  bool workspace_given;
  std::vector<Obstacle> obstacles;
  bool interactive_obstacles;
  double obstacle_speed;  // m/s
  double force_scale;     // m/N
};

std::vector<Obstacle> readObstacles(const Parameters& parameters) {
  std::vector<Obstacle> obstacles;
  if (!parameters.has("robot")) return obstacles;
  for (const ObstacleDescription& description : readRobotDescription(parameters.text("robot")).obstacles) {
    obstacles.push_back(makeObstacle(description));
  }
  return obstacles;
}

Settings readSettings(const Parameters& parameters) {
  Settings settings;
  settings.rate = parameters.numberOr("rate", 20, 1, 200);
  settings.trail_duration = parameters.numberOr("trail_duration", 10, 0.1, 600);
  settings.world_frame = parameters.textOr("world_frame", "world");
  settings.interactive = parameters.flagOr("interactive", true);
  settings.obstacles = readObstacles(parameters);
  settings.interactive_obstacles = parameters.flagOr("interactive_obstacles", false);
  settings.obstacle_speed = parameters.numberOr("obstacle_speed", 0.05, 1e-4, 10);
  settings.force_scale = parameters.numberOr("force_scale", 0.1, 1e-6, 1e3);
  Workspace& workspace = settings.workspace;
  settings.workspace_given = parameters.has("workspace/min") || parameters.has("workspace/max") ||
                             parameters.has("workspace/radius") || parameters.has("workspace/centre");
  workspace.box.min() = parameters.vec3Or("workspace/min", workspace.box.min());
  workspace.box.max() = parameters.vec3Or("workspace/max", workspace.box.max());
  if (workspace.box.isEmpty()) parameters.fail("workspace/max", "a corner below workspace/min", "the upper corner [m]");
  workspace.radius = parameters.numberOr("workspace/radius", workspace.radius, 0);
  workspace.centre = parameters.vec3Or("workspace/centre", Vec3::Zero());
  if (!workspace.box.contains(workspace.centre) && workspace.radius < Workspace::kUnbounded) {
    parameters.fail("workspace/centre", "a point outside the box", "a point of the box [m]");
  }
  return settings;
}

class VisualizationNode {
 public:
  VisualizationNode(ros::NodeHandle node, const Settings& settings)
      : settings_(settings),
        listener_(transforms_),
        handles_(makeHandles(node)),
        obstacle_handles_(makeObstacleHandles(node)),
        obstacle_drawing_(settings.obstacles),
        markers_(node.advertise<visualization_msgs::MarkerArray>("markers", 2)),
        body_subscriber_(node.subscribe("body_state", 2, &VisualizationNode::onBody, this)),
        plant_subscriber_(node.subscribe("plant/body_state", 2, &VisualizationNode::onPlant, this)),
        controller_subscriber_(node.subscribe("controller_state", 10, &VisualizationNode::onController, this)),
        contacts_subscriber_(node.subscribe("contacts", 2, &VisualizationNode::onContacts, this)),
        obstacles_subscriber_(node.subscribe("obstacles", 2, &VisualizationNode::onObstacles, this)),
        tracked_subscriber_(node.subscribe("tracked_obstacles", 10, &VisualizationNode::onTracked, this)),
        timer_(node.createWallTimer(ros::WallDuration(1 / settings.rate), &VisualizationNode::draw, this)) {}

 private:
  template <typename Message>
  struct Newest {
    typename Message::ConstPtr message;
    ros::SteadyTime arrival;

    void set(const typename Message::ConstPtr& newest) {
      message = newest;
      arrival = ros::SteadyTime::now();
    }
    bool fresh() const { return message && (ros::SteadyTime::now() - arrival).toSec() < kStale; }
  };

  struct Trails {
    Trail effector, target;
    ros::Time last;
  };

  std::unique_ptr<TargetHandles> makeHandles(ros::NodeHandle& node) const {
    if (!settings_.interactive) return nullptr;
    return std::make_unique<TargetHandles>(node.resolveName("target_handles"),
                                           node.advertise<EffectorTargets>("targets", 10), transforms_);
  }

  std::unique_ptr<ObstacleHandles> makeObstacleHandles(ros::NodeHandle& node) const {
    if (!settings_.interactive_obstacles) return nullptr;
    return std::make_unique<ObstacleHandles>(node.resolveName("obstacle_handles"),
                                             node.advertise<TrackedObstacles>("tracked_obstacles", 10), transforms_,
                                             settings_.obstacles, settings_.obstacle_speed);
  }

  void onContacts(const ContactArray::ConstPtr& message) {
    if (!message->header.frame_id.empty()) contacts_.set(message);
  }

  void onObstacles(const TrackedObstacles::ConstPtr& message) {
    if (!message->header.frame_id.empty()) obstacles_.set(message);
  }

  void onTracked(const ros::MessageEvent<const TrackedObstacles>& event) {
    if (obstacle_handles_ && event.getPublisherName() != ros::this_node::getName()) {
      obstacle_handles_->yield(*event.getConstMessage());
    }
  }

  void onBody(const BodyState::ConstPtr& message) {
    if (accept(*message, "body_state")) body_.set(message);
  }

  void onPlant(const BodyState::ConstPtr& message) {
    if (accept(*message, "plant/body_state")) plant_.set(message);
  }

  bool accept(const BodyState& body, const char* topic) {
    const bool good = isConsistent(body);
    if (!good) ROS_WARN_THROTTLE(5, "%s is not drawn: its sizes do not fit together or its frame is empty", topic);
    if (good && extent_ == 0) extent_ = calcExtent(body);
    return good;
  }

  void onController(const ControllerState::ConstPtr& message) {
    if (message->header.frame_id.empty()) return;
    controller_.set(message);
    for (const EffectorState& effector : message->effectors) addToTrails(*message, effector);
  }

  void addToTrails(const ControllerState& state, const EffectorState& effector) {
    const Trails fresh{Trail(settings_.trail_duration, kTrailColour),
                       Trail(settings_.trail_duration, kTargetTrailColour), ros::Time()};
    Trails& trails = trails_.emplace(effector.name, fresh).first->second;
    const ros::Time stamp = state.header.stamp;
    if (stamp >= trails.last && stamp < trails.last + ros::Duration(kTrailSpacing)) return;
    trails.last = stamp;
    trails.effector.add(stamp, toVec3(effector.position));
    if (state.status == ControllerState::DISABLED || !effector.targeted) return;
    trails.target.add(stamp, toVec3(effector.target));
  }

  Light calcLight(const std::string& frame) const {
    try {
      const auto transform = transforms_.lookupTransform(settings_.world_frame, frame, ros::Time(0));
      return Light().seenFrom(tf2::transformToEigen(transform).linear());
    } catch (const tf2::TransformException&) {
      return Light();
    }
  }

  void draw(const ros::WallTimerEvent&) {
    if (handles_ && controller_.fresh() && extent_ > 0) updateHandles(*controller_.message);
    if (obstacle_handles_) {
      if (obstacles_.fresh()) obstacle_handles_->update(*obstacles_.message);
      obstacle_handles_->report(1 / settings_.rate);
    }
    if (markers_.getNumSubscribers() == 0) return;
    visualization_msgs::MarkerArray markers;
    if (plant_.fresh()) {
      const BodyStyle style{"plant_", kPlant, Colour::Zero(), false};
      addBody(*plant_.message, style, calcLight(plant_.message->header.frame_id), extent_, markers);
    }
    if (body_.fresh()) {
      const BodyStyle style{"", kSilicone, kSiliconeEdges, true};
      addBody(*body_.message, style, calcLight(body_.message->header.frame_id), extent_, markers);
    }
    if (controller_.fresh() && extent_ > 0) drawController(*controller_.message, markers);
    if (extent_ > 0) drawSurroundings(markers);
    if (!markers.markers.empty()) markers_.publish(markers);
  }

  void drawSurroundings(visualization_msgs::MarkerArray& markers) const {
    if (obstacles_.fresh()) {
      const Light light = calcLight(obstacles_.message->header.frame_id);
      obstacle_drawing_.add(*obstacles_.message, light, kPlaneSize * extent_, markers);
    }
    const ContactStyle style{kContactRadius * extent_, settings_.force_scale, kLongestForce * extent_};
    if (contacts_.fresh()) addContacts(*contacts_.message, style, markers);
  }

  void drawController(const ControllerState& state, visualization_msgs::MarkerArray& markers) const {
    addEffectors(state, extent_, markers);
    if (body_.fresh()) addLimits(state, *body_.message, extent_, markers);
    int id = 0;
    for (const auto& [name, trails] : trails_) {
      trails.target.draw(state.header, "target_trails", id, 0.6 * kTrailWidth * extent_, markers);
      trails.effector.draw(state.header, "effector_trails", id++, kTrailWidth * extent_, markers);
    }
  }

  void updateHandles(const ControllerState& state) {
    if (!settings_.workspace_given && state.status != ControllerState::DISABLED && !state.effectors.empty()) {
      settings_.workspace.centre = toVec3(state.effectors.front().position);
      settings_.workspace.radius = kDefaultReach * extent_;
      settings_.workspace_given = true;
    }
    handles_->update(state, settings_.workspace, kHandleSize * extent_);
  }

  Settings settings_;
  double extent_ = 0;  ///< m, of the first body seen: sizes strokes and the default workspace
  tf2_ros::Buffer transforms_;
  tf2_ros::TransformListener listener_;
  std::unique_ptr<TargetHandles> handles_;             ///< null unless interactive
  std::unique_ptr<ObstacleHandles> obstacle_handles_;  ///< null unless interactive
  ObstacleDrawing obstacle_drawing_;
  Newest<BodyState> body_, plant_;
  Newest<ContactArray> contacts_;
  Newest<TrackedObstacles> obstacles_;
  Newest<ControllerState> controller_;
  std::map<std::string, Trails> trails_;  // by effector name
  ros::Publisher markers_;
  ros::Subscriber body_subscriber_, plant_subscriber_, controller_subscriber_;
  ros::Subscriber contacts_subscriber_, obstacles_subscriber_, tracked_subscriber_;
  ros::WallTimer timer_;
};

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  ros::init(argc, argv, "visualization");
  try {
    sinew::VisualizationNode node(ros::NodeHandle(), sinew::readSettings(sinew::Parameters(ros::NodeHandle("~"))));
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return 1;
  }
}
