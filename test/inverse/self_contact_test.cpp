// The finger bent so far that its ribs press against each other.

#include <algorithm>
#include <set>

#include "check_line.h"
#include "common/complaint.h"
#include "inverse/robots.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/contact_finder.h"

namespace sinew {
namespace {

class SelfContact : public testing::Test {
 protected:
  static RobotDescription makeDescription(bool self) {
    RobotDescription description = readShippedRobot("finger");
    description.obstacles.clear();
    description.contacts.self = self;
    description.contacts.alarm_distance = 0.003;
    description.contacts.contact_distance = 0.0005;
    return description;
  }

  static void bend(ForwardSimulator& forward) {
    Actuation pull = forward.makeActuation();
    for (int k = 1; k <= 40; ++k) {
      pull.value = VecX::Constant(2, 0.022 * std::min(1.0, k / 30.0));
      ASSERT_EQ(forward.step(pull, 0.01), ForwardStatus::kSolved);
    }
    ASSERT_EQ(forward.settle(pull, 1e-8, 500), ForwardStatus::kSolved);
  }
};

TEST_F(SelfContact, TheRibsPressAndDoNotPass) {
  ForwardSimulator forward(makeRobot(makeDescription(true)));
  bend(forward);
  double depth = 0;
  for (int i = 0; i < forward.contacts().size(); ++i) depth = std::max(depth, -forward.contacts().row(i).gap);
  EXPECT_GT(forward.contactForce().maxCoeff(), 0.1) << "N";
  checkFigure("self_contact.depth", 1e3 * depth, "<=", 0.01, "mm");
}

// Forces within the body leave its weight to the base: the contacts' resultant on it is nothing.
TEST_F(SelfContact, ItsForcesBalanceEachOther) {
  ForwardSimulator forward(makeRobot(makeDescription(true)));
  bend(forward);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (int i = 0; i < forward.contacts().size(); ++i) {
    const ContactRow& row = forward.contacts().row(i);
    for (int k = 0; k < row.entries; ++k) {
      const ContactEntry& entry = forward.contacts().entries(i)[k];
      const Vec3 force = forward.contactForce()[i] * entry.gradient;
      sum += force;
      moment += forward.nodes()[static_cast<std::size_t>(entry.node)].cross(force);
    }
  }
  EXPECT_LT(sum.norm(), 1e-9 * forward.contactForce().sum()) << "N";
  EXPECT_LT(moment.norm(), 1e-6 * forward.contactForce().sum()) << "N m";
}

TEST_F(SelfContact, WithoutItTheRibsWouldPass) {
  ForwardSimulator passing(makeRobot(makeDescription(false))), touching(makeRobot(makeDescription(true)));
  bend(passing);
  bend(touching);
  EXPECT_GT((passing.effectors() - touching.effectors()).norm(), 0.002) << "m";
}

RegionDescription makeRegion(const std::string& name, double low, double high) {
  RegionDescription region;
  region.name = name;
  region.boxes = {{Vec3(-1, -1, low), Vec3(1, 1, high)}};
  return region;
}

// Every rib with every other, or the lowest two alone: contacts are those of all pairs that lie in the named regions.
TEST_F(SelfContact, OnlyNamedRegionsTouch) {
  const RobotDescription everything = makeDescription(true);
  RobotDescription whole = everything, low = everything;
  whole.contacts.regions = {makeRegion("whole", -1, 1)};
  whole.contacts.self_pairs = {{{0, 0}}};
  low.contacts.regions = {makeRegion("first", -1, 0.022), makeRegion("second", 0.027, 0.048)};
  low.contacts.self_pairs = {{{0, 1}}};
  ForwardSimulator forward(makeRobot(everything));
  bend(forward);
  const auto find = [&](const RobotDescription& description) {
    const auto robot = makeRobot(description);
    ContactFinder finder(*robot);
    StageTimes times;
    std::set<std::uint64_t> keys;
    const ContactList& list = finder.find(forward.nodes(), times);
    for (int i = 0; i < list.size(); ++i) keys.insert(list.row(i).key);
    return keys;
  };
  const std::set<std::uint64_t> all = find(everything), some = find(low);
  EXPECT_EQ(find(whole), all);
  EXPECT_FALSE(some.empty());
  EXPECT_LT(some.size(), all.size());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
}

TEST_F(SelfContact, ARegionHoldsAPartOfTheSurface) {
  RobotDescription description = makeDescription(true);
  description.contacts.regions = {makeRegion("tip", 0.08, 1), makeRegion("beyond", 0.2, 1)};
  description.contacts.self_pairs = {{{0, 1}}};
  const auto robot = makeRobot(description);
  const std::string words = complaintOf([&] { ContactFinder finder(*robot); });
  EXPECT_NE(
      words.find("finger.yaml: contacts.regions[1]: found 'beyond' without a node of the surface, expected boxes"),
      std::string::npos)
      << words;
}

TEST_F(SelfContact, TheInverseReachesWhatTheForwardReached) {
  const auto robot = makeRobot(makeDescription(true));
  ForwardSimulator forward(robot);
  bend(forward);
  InverseController inverse(robot);
  CycleInput input = inverse.makeInput();
  CycleOutput output = inverse.makeOutput();
  input.targeted[0] = true;
  input.targets = forward.effectors();
  int held = 0;
  for (int k = 0; k < 600; ++k) held += inverse.step(input, output) == CycleStatus::kHeld;
  checkFigure("self_contact.tip", 1e3 * output.effector_error, "<=", 0.1, "mm");
  checkFigure("self_contact.held_cycles", held, "<=", 0, "1");
}

}  // namespace
}  // namespace sinew
