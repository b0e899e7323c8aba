#include "sinew/mesh/vtk_reader.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/bar_mesh.h"
#include "mesh/mesh_files.h"

namespace sinew {
namespace {

using Region = VtkOptions::Region;

TetMesh makeTaggedBar() {
  TetMesh mesh = makeBarMesh(Vec3(0.3, 0.2, 0.1), 3, 2, 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.region[t] = static_cast<int>(t % 4);
  return mesh;
}

class VtkReaderTest : public testing::Test {
 protected:
  TetMesh read(const std::string& bytes) const { return readVtk(folder_.write("mesh.vtk", bytes)); }

  void expectSame(const VtkOptions& options) const {
    const TetMesh found = read(makeVtkFile(mesh_, options));
    ASSERT_EQ(found.nodes.size(), mesh_.nodes.size());
    const double tolerance = options.float_points ? 1e-7 : 0;
    for (std::size_t i = 0; i < mesh_.nodes.size(); ++i) {
      EXPECT_LE((found.nodes[i] - mesh_.nodes[i]).norm(), tolerance);
    }
    EXPECT_EQ(found.tets, mesh_.tets);
    EXPECT_EQ(found.region, options.region == Region::kNone ? std::vector<int>(mesh_.tets.size(), 0) : mesh_.region);
  }

  /// Expects an error after `from` has been replaced by `to` in a good text file.
  void expectError(const std::string& from, const std::string& to, std::initializer_list<std::string> words,
                   double version = 2.0) const {
    VtkOptions options;
    options.version = version;
    options.region = Region::kField;
    const std::string bytes = replaced(makeVtkFile(mesh_, options), from, to);
    expectConfigError([&] { read(bytes); }, words);
  }

  TempFolder folder_;
  TetMesh mesh_ = makeTaggedBar();
};

TEST_F(VtkReaderTest, ReadsEveryCombination) {
  for (const bool binary : {false, true}) {
    for (const double version : {1.0, 2.0, 3.0, 4.2, 5.0, 5.1}) {
      for (const bool is_float : {false, true}) {
        for (const Region region : {Region::kNone, Region::kScalars, Region::kField}) {
          for (const char* line_end : {"\n", "\r\n"}) {
            SCOPED_TRACE(testing::Message()
                         << "binary " << binary << ", version " << version << ", float " << is_float << ", region "
                         << static_cast<int>(region) << ", line end " << (line_end[0] == '\r' ? "CRLF" : "LF"));
            VtkOptions options;
            options.binary = binary;
            options.version = version;
            options.float_points = is_float;
            options.float_region = is_float;
            options.region = region;
            options.line_end = line_end;
            expectSame(options);
          }
        }
      }
    }
  }
}

TEST_F(VtkReaderTest, ReadsASmallFileWrittenByHand) {
  const TetMesh mesh = read(
      "# vtk DataFile Version 3.0\n\nascii\ndataset unstructured_grid\n\npoints 4 float\n0 0 0  1 0 0\n0 1 0  0 0 1e0\n"
      "\ncells 1 5\n4 0 1 2 3\ncell_types 1\n10");
  ASSERT_EQ(mesh.tets.size(), 1u);
  EXPECT_EQ(mesh.tets[0], (std::array<int, 4>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.nodes[3], Vec3(0, 0, 1));
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithTheHeader) {
  expectConfigError([&] { read(""); }, {"mesh.vtk", "# vtk DataFile Version"});
  expectConfigError([&] { read("solid finger\n"); }, {"line 1", "# vtk DataFile Version"});
  expectError("Version 2.0", "Version 7.2", {"line 1", "7.2", "1.0 to 5.1", "convert_mesh"});
  expectError("ASCII", "EBCDIC", {"line 3", "'ebcdic'", "ASCII or BINARY"});
  expectError("UNSTRUCTURED_GRID", "POLYDATA", {"line 4", "'polydata'", "UNSTRUCTURED_GRID", "convert_mesh"});
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithCounts) {
  expectError("POINTS 24", "POINTS 999999999999", {"999999999999, more than the", "bytes that follow"});
  expectError("POINTS 24", "POINTS -24", {"-24"});
  expectError("POINTS 24 double", "POINTS 23 double", {"line 9", "a keyword of the VTK legacy format"});
  expectError("POINTS 24 double", "POINTS 24 quaternion", {"'quaternion'", "a number type"});
  expectError("CELLS 41", "CELLS 40", {"a cell list longer than its cells"});
  expectError("CELLS 41", "CELLS 99", {"ends early"});
  expectError("CELL_TYPES 41", "CELL_TYPES 40", {"keyword"});
  expectError("CELL_TYPES 41", "CELL_TYPES 42", {"'POINT_DATA'", "cell types"});
  expectError("region 1 41", "region 1 40", {"keyword"});
  expectError("quality 2 41", "quality 0 41", {"0 components"});
  expectError("quality 2 41", "quality 9223372036854775807 41", {"components"});
  expectError("quality 2 41", "quality 60000 9223372036854775807", {"9223372036854775807, more than"});
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithCells) {
  expectError("\n1 0 2 0 1", "\n1 0 2 0 x", {"line 16", "'x'", "the cell list"});
  expectError("\n1 0 2 0 1", "\n1 0 -2 0 1", {"-2", "a number of points that fits"});
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithTetrahedra) {
  std::string bytes = makeVtkFile(mesh_, {});
  const std::string tet = "4 0 1 5 17 ";
  expectConfigError([&] { read(replaced(bytes, tet, "4 0 1 5 24 ")); }, {"cell 4 with point 24", "24 points"});
  expectConfigError([&] { read(replaced(bytes, tet, "4 0 1 5 -1 ")); }, {"cell 4 with point -1"});
  expectConfigError([&] { read(replaced(bytes, tet, "4 0 1 5 1.5 ")); }, {"cell 4 with point 1.5"});
  expectConfigError([&] { read(replaced(bytes, "1 3 5 14 10 5", "1 3 5 14 24 5")); }, {"second-order", "convert_mesh"});
  expectConfigError([&] { read(replaced(bytes, "1 3 5 14 10 5", "1 3 10 14 10 5")); },
                    {"cell 2", "tetrahedron of 3 points"});
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithOffsets) {
  expectError("\n0 1 3 6 ", "\n0 3 1 6 ", {"cell offsets that fall"}, 5.1);
  expectError("\n0 1 3 6 ", "\n0 1 3 600000 ", {"600000", "within the connectivity"}, 5.1);
  expectError("OFFSETS", "OFFSET", {"'OFFSET'", "OFFSETS"}, 5.1);
}

TEST_F(VtkReaderTest, NamesWhatIsWrongWithRegions) {
  VtkOptions options;
  options.region = Region::kScalars;
  const std::string bytes = makeVtkFile(mesh_, options);
  const std::string values = "LOOKUP_TABLE default\n-1 -1 -1 -1 0 ";
  expectConfigError([&] { read(replaced(bytes, values, "LOOKUP_TABLE default\n-1 -1 -1 -1 0.5 ")); },
                    {"'region' with the value 0.5", "integers"});
  expectConfigError([&] { read(replaced(bytes, values, "LOOKUP_TABLE default\n-1 -1 -1 -1 nan ")); }, {"'region'"});
  expectConfigError([&] { read(replaced(bytes, "CELL_DATA 41", "CELL_DATA 40")); }, {"mesh.vtk"});
}

}  // namespace
}  // namespace sinew
