#include "sinew/robot/robot_description.h"

#include <set>

#include "sinew/common/config_error.h"
#include "sinew/common/yaml_reader.h"
#include "sinew/robot/urdf_frames.h"

namespace sinew {
namespace {

void readMesh(const YamlReader& yaml, RobotDescription& robot) {
  const YamlReader mesh = yaml.map("mesh");
  robot.mesh_file = mesh.path("file");
  robot.mesh_scale = mesh.positiveOr("scale", 1.0);
  robot.mesh_pieces = mesh.integerOr("pieces", 1, 1, 1000);
  mesh.refuseUnknownKeys();
}

void readGravity(const YamlReader& yaml, RobotDescription& robot) {
  const YamlReader gravity = yaml.map("gravity");
  const Vec3 vector = gravity.vec3("vector");
  const std::string frame = gravity.textOr("frame", robot.frame);
  gravity.refuseUnknownKeys();
  if (vector.norm() > 100) gravity.fail("vector", "an acceleration in m/s2, [0, 0, -9.81] on Earth");
  if (frame == robot.frame) {
    robot.gravity = vector;
    return;
  }
  if (robot.urdf_file.empty())
    gravity.fail("frame", "'" + robot.frame + "', or a link of a URDF named by the key urdf");
  robot.gravity = readUrdfPose(robot.urdf_file, robot.frame, frame).linear() * vector;
}

MaterialDescription readMaterial(const YamlReader& yaml) {
  MaterialDescription material;
  if (yaml.has("region")) material.region = yaml.integer("region", 0, 1 << 30);
  material.young_modulus = yaml.positive("young_modulus");
  material.poisson_ratio = yaml.number("poisson_ratio", -0.99, 0.4999);
  if (yaml.has("density") == yaml.has("total_mass")) {
    yaml.fail("density", "either density [kg/m3] or total_mass [kg], one of the two");
  }
  if (yaml.has("density")) material.density = yaml.number("density", 0, 1e5);
  if (yaml.has("total_mass")) material.total_mass = yaml.positive("total_mass");
  yaml.refuseUnknownKeys();
  return material;
}

std::vector<MaterialDescription> readMaterials(const YamlReader& yaml) {
  std::vector<MaterialDescription> materials;
  std::set<int> regions;
  for (const YamlReader& item : yaml.maps("materials")) {
    materials.push_back(readMaterial(item));
    if (!regions.insert(materials.back().region).second) item.fail("region", "each region once");
  }
  if (materials.empty()) yaml.fail("materials", "a list of one material or more");
  return materials;
}

// Boxes and spheres; the caller refuses unknown keys.
void readShapes(const YamlReader& yaml, RegionDescription& region) {
  for (const YamlReader& item : yaml.maps("boxes")) {
    region.boxes.push_back({item.vec3("min"), item.vec3("max")});
    if (!(region.boxes.back().min.array() <= region.boxes.back().max.array()).all()) {
      item.fail("max", "no coordinate below that of min");
    }
    item.refuseUnknownKeys();
  }
  for (const YamlReader& item : yaml.maps("spheres")) {
    region.spheres.push_back({item.vec3("centre"), item.positive("radius")});
    item.refuseUnknownKeys();
  }
}

FixedNodesDescription readFixedNodes(const YamlReader& yaml) {
  FixedNodesDescription fixed;
  const YamlReader map = yaml.map("fixed");
  readShapes(map, fixed);
  if (map.has("nodes")) fixed.nodes = map.integerList("nodes", 0, 1 << 30);
  map.refuseUnknownKeys();
  return fixed;
}

Limits readLimits(const YamlReader& yaml, const std::string& key, const Limits& otherwise) {
  if (!yaml.has(key)) return otherwise;
  const YamlReader map = yaml.map(key);
  Limits limits;
  limits.min = map.numberOr("min", otherwise.min);
  limits.max = map.numberOr("max", otherwise.max);
  limits.rate = map.numberOr("rate", otherwise.rate, 0);
  if (limits.min > limits.max) map.fail("max", "a number >= min");
  if (limits.rate == 0) map.fail("rate", "a number > 0");
  map.refuseUnknownKeys();
  return limits;
}

void refuseDuplicate(const YamlReader& item, const std::string& name, std::set<std::string>& names) {
  if (!names.insert(name).second) item.fail("name", "a name used once");
}

std::vector<CableDescription> readCables(const YamlReader& yaml) {
  const Limits pull_only{0, kUnlimited, kUnlimited};
  std::vector<CableDescription> cables;
  std::set<std::string> names;
  for (const YamlReader& item : yaml.maps("cables")) {
    CableDescription cable;
    cable.name = item.text("name");
    refuseDuplicate(item, cable.name, names);
    cable.pull_point = item.vec3("pull_point");
    cable.via_points = item.vec3List("via_points");
    if (cable.via_points.empty()) item.fail("via_points", "one point or more, the last one the cable's anchor");
    cable.displacement = readLimits(item, "displacement", Limits());
    if (cable.displacement.min > 0) item.map("displacement").fail("min", "a number <= 0: the cable starts at 0");
    if (cable.displacement.max < 0) item.map("displacement").fail("max", "a number >= 0: the cable starts at 0");
    cable.tension = readLimits(item, "tension", pull_only);
    cable.tube_stiffness = item.numberOr("tube_stiffness", 0, 0);
    item.refuseUnknownKeys();
    cables.push_back(cable);
  }
  if (cables.empty()) yaml.fail("cables", "a list of one cable or more");
  return cables;
}

CarrierDescription readCarrier(const YamlReader& yaml, const std::vector<CableDescription>& cables) {
  CarrierDescription carrier;
  if (!yaml.has("carrier")) return carrier;
  const YamlReader map = yaml.map("carrier");
  carrier.name = map.text("name");
  for (const CableDescription& cable : cables) {
    if (cable.name == carrier.name) map.fail("name", "a name that no cable has");
  }
  carrier.axis = map.vec3("axis");
  if (!(carrier.axis.norm() > 0)) map.fail("axis", "the direction of positive travel, not zero");
  carrier.displacement = readLimits(map, "displacement", Limits());
  if (carrier.displacement.min > 0) map.map("displacement").fail("min", "a number <= 0: the carrier starts at 0");
  if (carrier.displacement.max < 0) map.map("displacement").fail("max", "a number >= 0: the carrier starts at 0");
  map.refuseUnknownKeys();
  return carrier;
}

std::array<bool, 3> readAxes(const YamlReader& yaml) {
  std::array<bool, 3> axes{{false, false, false}};
  for (const std::string& axis : yaml.textList("axes")) {
    if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z') yaml.fail("axes", "a list of x, y, z");
    axes[static_cast<std::size_t>(axis[0] - 'x')] = true;
  }
  if (axes == std::array<bool, 3>{{false, false, false}}) yaml.fail("axes", "one axis or more of x, y, z");
  return axes;
}

std::vector<EffectorDescription> readEffectors(const YamlReader& yaml) {
  std::vector<EffectorDescription> effectors;
  std::set<std::string> names;
  for (const YamlReader& item : yaml.maps("effectors")) {
    EffectorDescription effector;
    effector.name = item.text("name");
    refuseDuplicate(item, effector.name, names);
    effector.point = item.vec3("point");
    if (item.has("axes")) effector.axes = readAxes(item);
    effector.weight = item.positiveOr("weight", 1.0);
    effector.hold = item.flagOr("hold", false);
    item.refuseUnknownKeys();
    effectors.push_back(effector);
  }
  if (effectors.empty()) yaml.fail("effectors", "a list of one effector or more");
  return effectors;
}

void readDamping(const YamlReader& yaml, RobotDescription& robot) {
  if (!yaml.has("damping")) return;
  const YamlReader damping = yaml.map("damping");
  robot.damping_mass = damping.numberOr("mass", 0, 0);
  robot.damping_stiffness = damping.numberOr("stiffness", 0, 0);
  damping.refuseUnknownKeys();
}

ControlDescription readControl(const YamlReader& yaml) {
  ControlDescription control;
  if (!yaml.has("control")) return control;
  const YamlReader map = yaml.map("control");
  control.model = map.choiceOr("model", {"static", "dynamic"}, 0) == 0 ? MotionModel::kStatic : MotionModel::kDynamic;
  control.cholesky = map.choiceOr("cholesky", {"supernodal", "cholmod"}, 0) == 0 ? CholeskyMethod::kSupernodal
                                                                                 : CholeskyMethod::kCholmod;
  control.threads = map.integerOr("threads", control.threads, 1, 64);
  control.newton_steps = map.integerOr("newton_steps", control.newton_steps, 1, 100);
  control.max_node_step = map.positiveOr("max_node_step", control.max_node_step);
  control.reach_per_cycle = map.positiveOr("reach_per_cycle", control.reach_per_cycle);
  control.smoothing = map.numberOr("smoothing", control.smoothing, 0);
  control.max_pieces = map.integerOr("max_pieces", control.max_pieces, 1, 1000000);
  control.max_nodes = map.integerOr("max_nodes", control.max_nodes, 0, 1000000);
  control.search_time = map.numberOr("search_time", control.search_time, 0);
  control.switching_margin = map.numberOr("switching_margin", control.switching_margin, 0, 1);
  control.switching_reach = map.numberOr("switching_reach", control.switching_reach, 0);
  map.refuseUnknownKeys();
  return control;
}

ObstacleGeometry readPlane(const YamlReader& yaml) {
  ObstacleGeometry plane;
  plane.kind = ObstacleGeometry::Kind::kPlane;
  const Vec3 normal = yaml.vec3("normal");
  if (!(normal.norm() > 0)) yaml.fail("normal", "the direction that points out of the half space, not zero");
  plane.origin.linear() = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normal).toRotationMatrix();
  plane.origin.translation() = yaml.vec3("point");
  yaml.refuseUnknownKeys();
  return plane;
}

// A plane of the robot's frame, or a link of the URDF.
ObstacleDescription readObstacle(const YamlReader& yaml, const RobotDescription& robot) {
  ObstacleDescription obstacle;
  obstacle.name = yaml.text("name");
  obstacle.tracked = yaml.flagOr("tracked", false);
  if (yaml.has("plane") == yaml.has("link")) {
    yaml.fail("link", "either link (of the URDF, with collision geometry) or plane, one of the two");
  }
  if (yaml.has("plane")) {
    obstacle.geometries = {readPlane(yaml.map("plane"))};
  } else {
    const std::string link = yaml.text("link");
    if (robot.urdf_file.empty()) yaml.fail("link", "a URDF named by the key urdf, with this link in it");
    obstacle.geometries = readUrdfCollision(robot.urdf_file, link);
    obstacle.pose = readUrdfPose(robot.urdf_file, robot.frame, link);
  }
  yaml.refuseUnknownKeys();
  return obstacle;
}

std::vector<ObstacleDescription> readObstacles(const YamlReader& yaml, const RobotDescription& robot) {
  std::vector<ObstacleDescription> obstacles;
  std::set<std::string> names;
  for (const YamlReader& item : yaml.maps("obstacles")) {
    obstacles.push_back(readObstacle(item, robot));
    refuseDuplicate(item, obstacles.back().name, names);
  }
  return obstacles;
}

std::vector<RegionDescription> readRegions(const YamlReader& yaml) {
  std::vector<RegionDescription> regions;
  std::set<std::string> names;
  for (const YamlReader& item : yaml.maps("regions")) {
    RegionDescription region;
    region.name = item.text("name");
    refuseDuplicate(item, region.name, names);
    readShapes(item, region);
    if (region.boxes.empty() && region.spheres.empty()) item.fail("boxes", "one box or sphere or more");
    item.refuseUnknownKeys();
    regions.push_back(region);
  }
  return regions;
}

// true, false, or pairs of names of regions.
void readSelf(const YamlReader& yaml, ContactDescription& contacts) {
  if (!yaml.isList("self")) {
    contacts.self = yaml.flagOr("self", contacts.self);
    return;
  }
  const std::string expected = "true, false, or a list of pairs [REGION, REGION] of names listed under regions";
  const auto find = [&](const std::string& name) {
    for (std::size_t i = 0; i < contacts.regions.size(); ++i) {
      if (contacts.regions[i].name == name) return static_cast<int>(i);
    }
    yaml.fail("self", expected);
  };
  for (const std::vector<std::string>& names : yaml.textLists("self")) {
    if (names.size() != 2) yaml.fail("self", expected);
    contacts.self_pairs.push_back({find(names[0]), find(names[1])});
  }
  contacts.self = !contacts.self_pairs.empty();
}

ContactDescription readContacts(const YamlReader& yaml) {
  ContactDescription contacts;
  if (!yaml.has("contacts")) return contacts;
  const YamlReader map = yaml.map("contacts");
  contacts.method =
      map.choiceOr("method", {"proximity", "volume"}, 0) == 0 ? DetectionMethod::kProximity : DetectionMethod::kVolume;
  contacts.alarm_distance = map.positiveOr("alarm_distance", contacts.alarm_distance);
  contacts.contact_distance = map.positiveOr("contact_distance", contacts.contact_distance);
  if (contacts.contact_distance >= contacts.alarm_distance) {
    map.fail("contact_distance", "a distance below alarm_distance");
  }
  contacts.regions = readRegions(map);
  readSelf(map, contacts);
  contacts.max_contacts = map.integerOr("max_contacts", contacts.max_contacts, 1, 1000);
  contacts.resolution = map.integerOr("resolution", contacts.resolution, 8, 1024);
  map.refuseUnknownKeys();
  return contacts;
}

}  // namespace

std::vector<ActuatorLimits> listActuators(const RobotDescription& robot) {
  std::vector<ActuatorLimits> actuators;
  for (const CableDescription& cable : robot.cables) {
    actuators.push_back({cable.name, cable.displacement, cable.tension});
  }
  const CarrierDescription& carrier = robot.carrier;
  if (!carrier.name.empty()) actuators.push_back({carrier.name, carrier.displacement, Limits()});
  return actuators;
}

RobotDescription readRobotDescription(const std::string& path) {
  const YamlReader yaml = YamlReader::fromFile(path);
  RobotDescription robot;
  const bool based = yaml.has("base");
  if (based) robot = readRobotDescription(yaml.path("base"));
  const auto gives = [&](const std::string& key) { return !based || yaml.has(key); };
  robot.file = path;
  robot.name = yaml.text("name");
  if (gives("frame")) robot.frame = yaml.textOr("frame", robot.name + "_base");
  if (yaml.has("urdf")) robot.urdf_file = yaml.path("urdf");
  if (!robot.urdf_file.empty()) readUrdfPose(robot.urdf_file, robot.frame, robot.frame);
  if (gives("mesh")) readMesh(yaml, robot);
  if (gives("gravity")) readGravity(yaml, robot);
  if (gives("materials")) robot.materials = readMaterials(yaml);
  if (gives("fixed")) robot.fixed = readFixedNodes(yaml);
  if (gives("cables")) robot.cables = readCables(yaml);
  if (gives("carrier")) robot.carrier = readCarrier(yaml, robot.cables);
  if (gives("effectors")) robot.effectors = readEffectors(yaml);
  if (gives("damping")) readDamping(yaml, robot);
  if (gives("control")) robot.control = readControl(yaml);
  if (gives("obstacles")) robot.obstacles = readObstacles(yaml, robot);
  if (gives("contacts")) robot.contacts = readContacts(yaml);
  yaml.refuseUnknownKeys();
  return robot;
}

}  // namespace sinew
