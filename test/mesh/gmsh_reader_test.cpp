#include "sinew/mesh/gmsh_reader.h"

#include <gtest/gtest.h>

#include "mesh/bar_mesh.h"
#include "mesh/mesh_files.h"

namespace sinew {
namespace {

using Numbers = FileBuilder::Numbers;

/// Regions ascend with the tetrahedra, so that writing them volume by volume keeps their order.
TetMesh makeTaggedBar() {
  TetMesh mesh = makeBarMesh(Vec3(0.3, 0.2, 0.1), 3, 2, 1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.region[t] = t < 10 ? 0 : (t < 20 ? 2 : 5);
  return mesh;
}

class GmshReaderTest : public testing::Test {
 protected:
  TetMesh read(const std::string& bytes) const { return readGmsh(folder_.write("mesh.msh", bytes)); }

  void expectError(const std::string& from, const std::string& to, std::initializer_list<std::string> words) const {
    const std::string bytes = replaced(makeGmshFile(mesh_, {}), from, to);
    expectConfigError([&] { read(bytes); }, words);
  }

  TempFolder folder_;
  TetMesh mesh_ = makeTaggedBar();
};

TEST_F(GmshReaderTest, ReadsTextAndBothByteOrders) {
  for (const Numbers numbers : {Numbers::kText, Numbers::kLittleEndian, Numbers::kBigEndian}) {
    for (const char* line_end : {"\n", "\r\n"}) {
      SCOPED_TRACE(testing::Message() << "numbers " << static_cast<int>(numbers) << ", CRLF " << (line_end[0] == '\r'));
      const TetMesh found = read(makeGmshFile(mesh_, {numbers, line_end}));
      EXPECT_EQ(found.nodes, mesh_.nodes);
      EXPECT_EQ(found.tets, mesh_.tets);
      EXPECT_EQ(found.region, mesh_.region);
    }
  }
}

TEST_F(GmshReaderTest, ReadsAFileWithoutEntities) {
  const std::string bytes = makeGmshFile(mesh_, {});
  const std::size_t begin = bytes.find("$Entities");
  const std::string end = "$EndEntities\n";
  const TetMesh found = read(std::string(bytes).erase(begin, bytes.find(end) + end.size() - begin));
  EXPECT_EQ(found.tets, mesh_.tets);
  EXPECT_EQ(found.region, std::vector<int>(mesh_.tets.size(), 0));
}

TEST_F(GmshReaderTest, RefusesOtherVersionsAndSaysWhatToDo) {
  for (const char* version : {"2.2", "4", "4.0"}) {
    expectError("4.1 0 8", std::string(version) + " 0 8",
                {"mesh.msh, line 2", std::string("Gmsh format ") + version, "4.1", "gmsh -save -format msh41"});
  }
  expectError("4.1 0 8", "4.1 0 4", {"indices of 4 bytes", "8 bytes"});
  expectError("4.1 0 8", "4.1 2 8", {"2", "0 for text or 1 for binary"});
  expectConfigError([&] { read("# vtk DataFile Version 3.0\n"); }, {"line 1", "$MeshFormat"});
}

TEST_F(GmshReaderTest, RefusesHigherOrderAndUnknownElements) {
  expectError("3 100 4 10 ", "3 100 11 10 ", {"higher order (type 11)", "4 nodes", "convert_mesh"});
  expectError("3 100 4 10 ", "3 100 4000 10 ", {"element type 4000"});
}

TEST_F(GmshReaderTest, RefusesCountsThatCannotBe) {
  expectError("3 1 0 12 ", "3 1 0 99999999 ", {"99999999, more than", "nodes in a block"});
  expectError("3 1 0 12 ", "3 1 0 13 ", {"mesh.msh, line"});
  expectError("3 100 4 10 ", "3 100 4 18446744073709551615 ", {"'18446744073709551615'"});
  expectError("3 100 4 10 ", "3 100 4 -1 ", {"-1"});
  expectError("3 100 4 10 ", "3 100 4 11 ", {"mesh.msh, line"});
  expectError("$EndNodes", "$EndNode", {"$EndNodes"});
  expectError("$EndPhysicalNames", "$EndNames", {"the end of the file", "$EndPhysicalNames"});
}

TEST_F(GmshReaderTest, RefusesNodeTagsThatAreTwiceOrMissing) {
  expectError("\n46 49 ", "\n46 46 ", {"node tag 46 twice"});
  expectError("\n46 49 ", "\n46 1000 ", {"element with node tag 49", "$Nodes"});
}

}  // namespace
}  // namespace sinew
