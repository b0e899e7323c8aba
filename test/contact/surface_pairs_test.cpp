#include "sinew/contact/surface_pairs.h"

#include <gtest/gtest.h>

#include "check_line.h"
#include "contact/brute_force_minima.h"
#include "contact/shapes.h"

namespace sinew {
namespace {

constexpr double kSize = 0.02;  // m

std::vector<TriangleMesh> makeShapes() {
  return {makeTetrahedron(kSize), makeBar(Vec3::Constant(kSize), 1, 1, 1), makeFork(Vec3(kSize, kSize / 2, kSize)),
          makeBall(kSize / 2, 0)};
}

struct Scene {
  TriangleMesh a, b;
};

/// Two shapes at random poses, with the corners shaken so that no two edges are parallel.
Scene makeScene(Random& random, const std::vector<TriangleMesh>& shapes) {
  Scene scene = {shapes[random.index(static_cast<int>(shapes.size()))],
                 shapes[random.index(static_cast<int>(shapes.size()))]};
  for (TriangleMesh* mesh : {&scene.a, &scene.b}) {
    mesh->vertices = calcMoved(mesh->vertices, random.pose(0.8 * kSize));
    for (Vec3& x : mesh->vertices) x += random.vector(0.1 * kSize);
  }
  return scene;
}

double calcLeastDistance(const Scene& scene) {
  double least = 1e300;
  for (std::size_t ta = 0; ta < scene.a.triangles.size(); ++ta) {
    for (std::size_t tb = 0; tb < scene.b.triangles.size(); ++tb) {
      least = std::min(least, brute::nearestOfTriangles(cornersOf(scene.a, ta), cornersOf(scene.b, tb)).distance);
    }
  }
  return least;
}

bool areApart(const Scene& scene) {
  if (pierces(scene.a, scene.b) || pierces(scene.b, scene.a)) return false;
  const MeshDistance a(scene.a.vertices, scene.a.triangles);
  const MeshDistance b(scene.b.vertices, scene.b.triangles);
  return a.calcDistance(scene.b.vertices[scene.b.triangles[0][0]]).distance > 0 &&
         b.calcDistance(scene.a.vertices[scene.a.triangles[0][0]]).distance > 0;
}

/// Whether the line between the points leaves both bodies outwards: distance knows no inside.
bool looksOutside(const Scene& scene, const BruteMinimum& pair) {
  const MeshDistance a(scene.a.vertices, scene.a.triangles);
  const MeshDistance b(scene.b.vertices, scene.b.triangles);
  const Vec3 step = 1e-6 / pair.distance * (pair.q - pair.p);
  return a.calcDistance(pair.p + step).distance > 0 && b.calcDistance(pair.q - step).distance > 0;
}

ContactList detect(const Scene& scene, const ProximitySettings& settings) {
  const MovingSurface a(CollisionSurface(scene.a.triangles), scene.a.vertices);
  const MovingSurface b(CollisionSurface(scene.b.triangles), scene.b.vertices);
  SurfacePairs pairs(settings, a.topology().vertices(), b.topology().vertices(), 200);
  ContactList list(200, 1200);
  list.begin();
  pairs.addPairs(a, b, nullptr, 0, list);
  list.finish();
  return list;
}

TEST(SurfacePairs, WithoutSlopeAreTheLocalMinimaOfTheDistance) {
  Random random(1);
  const std::vector<TriangleMesh> shapes = makeShapes();
  ProximitySettings settings;
  settings.slope = 0;
  settings.alarm_distance = 0.4 * kSize;
  int scenes = 0, minima = 0, missing = 0, spurious = 0;
  double error = 0;
  while (scenes < 10000) {
    const Scene scene = makeScene(random, shapes);
    const double least = calcLeastDistance(scene);
    if (least < 1e-4 || least > settings.alarm_distance || !areApart(scene)) continue;
    ++scenes;
    const ContactList list = detect(scene, settings);
    std::vector<BruteMinimum> expected = calcLocalMinima(scene.a, scene.b, settings.alarm_distance);
    expected.erase(std::remove_if(expected.begin(), expected.end(),
                                  [&](const BruteMinimum& pair) { return !looksOutside(scene, pair); }),
                   expected.end());
    minima += static_cast<int>(expected.size());
    std::vector<bool> is_found(expected.size(), false);
    for (int i = 0; i < list.size(); ++i) {
      const ContactRow& row = list.row(i);
      bool is_known = false;
      for (std::size_t j = 0; j < expected.size(); ++j) {
        const double apart = std::max((row.point - expected[j].p).norm(), (row.other_point - expected[j].q).norm());
        if (apart > 1e-6) continue;
        error = std::max({error, apart, std::abs(row.gap + settings.contact_distance - expected[j].distance)});
        is_known = is_found[j] = true;
      }
      if (!is_known) ++spurious;
    }
    missing += static_cast<int>(std::count(is_found.begin(), is_found.end(), false));
  }
  EXPECT_GT(minima, scenes);
  checkFigure("detection_oracle.scenes", scenes, ">=", 10000, "scenes");
  checkFigure("detection_oracle.missing", missing, "<=", 0, "pairs");
  checkFigure("detection_oracle.spurious", spurious, "<=", 0, "pairs");
  checkFigure("detection_oracle.position", error, "<=", 1e-6, "m");
}

}  // namespace
}  // namespace sinew
