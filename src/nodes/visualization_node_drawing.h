#pragma once

#include <ros/time.h>
#include <sinew/BodyState.h>
#include <sinew/ControllerState.h>
#include <visualization_msgs/MarkerArray.h>

#include <deque>
#include <string>

#include "sinew/common/types.h"

namespace sinew {

/// Red, green, blue and opacity, 0 to 1.
using Colour = Vec4;

/// Light that the markers carry in their vertex colours: rviz itself shades no vertex-coloured triangles.
/// colour = base * (ambient + key max(n.k, 0) + fill max(n.f, 0)), both directions in the frame of the markers.
struct Light {
  Vec3 key = Vec3(0.4, -0.5, 0.77);     ///< unit vector towards the main lamp
  Vec3 fill = Vec3(-0.70, 0.65, -0.3);  ///< towards the weaker one
  Colour calcShade(const Vec3& normal, const Colour& base) const;
  /// The same lamps seen from a frame whose axes are the columns of `axes` in the present one.
  Light seenFrom(const Mat3& axes) const;
};

std_msgs::ColorRGBA toRgba(const Colour& colour);

/// A marker of unit size at the origin of the header's frame, which vanishes unless it is refreshed.
visualization_msgs::Marker makeMarker(const std_msgs::Header& header, const std::string& name, int id, int type);

/// How one body is drawn; the real robot's double is drawn translucent.
struct BodyStyle {
  std::string name;  ///< prefix of the marker namespaces
  Colour silicone;
  Colour edges;  ///< opacity 0 leaves them out
  bool cables = true;
};

/// Whether indices and counts fit together; what does not is not drawn.
bool isConsistent(const BodyState& body);

/// Length of the bounding box's diagonal [m]: every stroke is sized by it.
double calcExtent(const BodyState& body);

/// Surface, edges and cables of a consistent body. Cables run from blue (slack) to red (at the tension limit).
void addBody(const BodyState& body, const BodyStyle& style, const Light& light, double extent,
             visualization_msgs::MarkerArray& markers);

/// Effectors, their targets and the line of the error between them.
void addEffectors(const ControllerState& state, double extent, visualization_msgs::MarkerArray& markers);

/// For every active limit a red head at the cable's pull point and its name in words.
void addLimits(const ControllerState& state, const BodyState& body, double extent,
               visualization_msgs::MarkerArray& markers);

/// Blue through green and yellow to red as `ratio` goes from 0 to 1.
Colour calcTensionColour(double ratio);

/// Where a point has been in the last seconds, fading.
class Trail {
 public:
  Trail(double duration, const Colour& colour) : duration_(duration), colour_(colour) {}

  void add(ros::Time stamp, const Vec3& point);
  /// Appends nothing while there is no line to draw.
  void draw(const std_msgs::Header& header, const std::string& name, int id, double width,
            visualization_msgs::MarkerArray& markers) const;

 private:
  struct Sample {
    ros::Time stamp;
    Vec3 point;
  };
  double duration_;  ///< s
  Colour colour_;
  std::deque<Sample> samples_;
};

}  // namespace sinew
