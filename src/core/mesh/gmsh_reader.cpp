#include "sinew/mesh/gmsh_reader.h"

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>

#include "sinew/mesh/file_cursor.h"

namespace sinew {
namespace {

constexpr int kTetrahedron = 4;
constexpr std::array<int, 4> kHigherTetrahedra = {11, 29, 30, 31};
constexpr int kVolume = 3;  // dimension
constexpr const char* kHowToConvert = " (scripts/convert_mesh converts other files)";

/// Nodes of each element type of the Gmsh reference manual; 0 where a type is not listed there.
std::size_t calcNodesOfElement(int type) {
  static const std::unordered_map<int, std::size_t> kNodes = {
      {1, 2},   {2, 3},   {3, 4},   {4, 4},  {5, 8},  {6, 6},   {7, 5},   {8, 3},   {9, 6},   {10, 9},  {11, 10},
      {12, 27}, {13, 18}, {14, 14}, {15, 1}, {16, 8}, {17, 20}, {18, 15}, {19, 13}, {20, 9},  {21, 10}, {22, 12},
      {23, 15}, {24, 15}, {25, 21}, {26, 4}, {27, 5}, {28, 6},  {29, 20}, {30, 35}, {31, 56}, {92, 64}, {93, 125}};
  const auto found = kNodes.find(type);
  return found == kNodes.end() ? 0 : found->second;
}

class GmshReader {
 public:
  explicit GmshReader(const std::string& path) : file_(path) {}

  TetMesh read() {
    readFormat();
    while (!file_.isAtEnd()) readSection();
    return makeMesh();
  }

 private:
  using Tag = std::int64_t;
  struct Node {
    Tag tag;
    Vec3 position;
  };
  struct Tet {
    std::array<Tag, 4> nodes;
    int volume;  // entity
  };

  void readFormat();
  void readSection();
  void readEntities();
  void readEntity(int dimension);
  void readNodes();
  void readNodeBlock();
  void readElements();
  void readElementBlock();

  int readInt(const char* expected);
  std::int64_t readSize(const char* expected);
  double readReal(const char* expected);
  std::size_t readCount(std::size_t items_each, const char* expected);

  TetMesh makeMesh();
  void sortNodes();
  int findNode(Tag tag) const;

  FileCursor file_;
  bool is_binary_ = false;
  bool swap_ = false;
  std::vector<Node> nodes_;
  std::vector<Tet> tets_;
  std::unordered_map<int, int> group_of_volume_;
};

void GmshReader::readFormat() {
  if (file_.peekWord() != "$MeshFormat") file_.fail("another beginning", "a Gmsh file: '$MeshFormat'");
  file_.expectWord("$MeshFormat");
  const std::string version(file_.readWord("a version number"));
  if (version != "4.1") {
    file_.fail("Gmsh format " + version.substr(0, 8),
               "4.1: save it again with 'gmsh -save -format msh41', or with scripts/convert_mesh");
  }
  const std::int64_t is_binary = file_.readInteger("0 for text or 1 for binary");
  if (is_binary != 0 && is_binary != 1) file_.fail(std::to_string(is_binary), "0 for text or 1 for binary");
  is_binary_ = is_binary == 1;
  const std::int64_t size = file_.readInteger("the size of an index in bytes");
  if (size != 8) file_.fail("indices of " + std::to_string(size) + " bytes", "8 bytes");
  file_.readLine();
  if (is_binary_) {
    const auto one = file_.readBinary<std::int32_t>(false, "the number one that shows the byte order");
    swap_ = one != 1;
    if (swap_ && one != 0x01000000) file_.fail(std::to_string(one), "the number one that shows the byte order");
  }
  file_.expectWord("$EndMeshFormat");
}

void GmshReader::readSection() {
  const std::string name(file_.readWord("a section"));
  if (name.size() < 2 || name[0] != '$') file_.fail("'" + name.substr(0, 40) + "'", "a section such as $Nodes");
  if (is_binary_) file_.readLine();
  if (name == "$Entities") {
    readEntities();
  } else if (name == "$Nodes") {
    readNodes();
  } else if (name == "$Elements") {
    readElements();
  } else {
    return file_.skipPast("$End" + name.substr(1));
  }
  file_.expectWord("$End" + name.substr(1));
}

void GmshReader::readEntities() {
  std::array<std::int64_t, 4> counts;
  for (std::int64_t& count : counts) count = readSize("the number of entities");
  for (int dimension = 0; dimension <= kVolume; ++dimension) {
    for (std::int64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) readEntity(dimension);
  }
}

/// Tag, box (a point: position), physical groups, and for all but points the entities that bound it.
void GmshReader::readEntity(int dimension) {
  const int tag = readInt("the tag of an entity");
  const int reals = dimension == 0 ? 3 : 6;
  for (int i = 0; i < reals; ++i) readReal("the box of an entity");
  const std::size_t groups = readCount(1, "the number of physical groups");
  for (std::size_t i = 0; i < groups; ++i) {
    const int group = readInt("a physical group");
    if (dimension == kVolume) group_of_volume_.emplace(tag, group);
  }
  if (dimension == 0) return;
  const std::size_t bounds = readCount(1, "the number of bounding entities");
  for (std::size_t i = 0; i < bounds; ++i) readInt("a bounding entity");
}

void GmshReader::readNodes() {
  const std::int64_t blocks = readSize("the number of node blocks");
  for (const char* expected : {"the number of nodes", "the smallest node tag", "the largest node tag"}) {
    readSize(expected);
  }
  for (std::int64_t block = 0; block < blocks; ++block) readNodeBlock();
}

/// First all tags, then all positions, each followed by the parameters of the node on its entity if there are any.
void GmshReader::readNodeBlock() {
  const int dimension = readInt("the dimension of a node block");
  readInt("the entity of a node block");
  const bool is_parametric = readInt("whether nodes have parameters") != 0;
  const std::size_t count = readCount(4, "the number of nodes in a block");
  const std::size_t begin = nodes_.size();
  for (std::size_t i = 0; i < count; ++i) nodes_.push_back({readSize("a node tag"), Vec3::Zero()});
  for (std::size_t i = begin; i < nodes_.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) nodes_[i].position[axis] = readReal("a node coordinate");
    for (int parameter = 0; is_parametric && parameter < dimension; ++parameter) readReal("a node parameter");
  }
}

void GmshReader::readElements() {
  const std::int64_t blocks = readSize("the number of element blocks");
  for (const char* expected : {"the number of elements", "the smallest element tag", "the largest element tag"}) {
    readSize(expected);
  }
  for (std::int64_t block = 0; block < blocks; ++block) readElementBlock();
}

void GmshReader::readElementBlock() {
  readInt("the dimension of an element block");
  const int entity = readInt("the entity of an element block");
  const int type = readInt("an element type");
  if (std::count(kHigherTetrahedra.begin(), kHigherTetrahedra.end(), type) > 0) {
    file_.fail("tetrahedra of higher order (type " + std::to_string(type) + ")",
               std::string("linear ones, of 4 nodes (type 4)") + kHowToConvert);
  }
  const std::size_t nodes = calcNodesOfElement(type);
  if (nodes == 0) file_.fail("element type " + std::to_string(type), "a type of the Gmsh 4.1 manual");
  const std::size_t count = readCount(nodes + 1, "the number of elements in a block");
  for (std::size_t i = 0; i < count; ++i) {
    readSize("an element tag");
    Tet tet{{}, entity};
    for (std::size_t n = 0; n < nodes; ++n) {
      const Tag tag = readSize("a node tag of an element");
      if (n < 4) tet.nodes[n] = tag;
    }
    if (type == kTetrahedron) tets_.push_back(tet);
  }
}

int GmshReader::readInt(const char* expected) {
  if (is_binary_) return file_.readBinary<std::int32_t>(swap_, expected);
  const std::int64_t value = file_.readInteger(expected);
  if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
    file_.fail(std::to_string(value), std::string(expected) + " of 32 bit");
  }
  return static_cast<int>(value);
}

std::int64_t GmshReader::readSize(const char* expected) {
  const std::int64_t value = is_binary_ ? file_.readBinary<std::int64_t>(swap_, expected) : file_.readInteger(expected);
  if (value < 0) file_.fail(std::to_string(value), std::string(expected) + ", not negative");
  return value;
}

double GmshReader::readReal(const char* expected) {
  return is_binary_ ? file_.readBinary<double>(swap_, expected) : file_.readReal(expected);
}

/// A count of items of `items_each` numbers, checked against what is left of the file.
std::size_t GmshReader::readCount(std::size_t items_each, const char* expected) {
  const std::size_t bytes = is_binary_ ? sizeof(std::int32_t) : 2;  // text: a digit and a space
  return file_.checkCount(readSize(expected), items_each * bytes, expected);
}

TetMesh GmshReader::makeMesh() {
  sortNodes();
  TetMesh mesh;
  for (const Node& node : nodes_) mesh.nodes.push_back(node.position);
  for (const Tet& tet : tets_) {
    mesh.tets.push_back(
        {findNode(tet.nodes[0]), findNode(tet.nodes[1]), findNode(tet.nodes[2]), findNode(tet.nodes[3])});
    const auto group = group_of_volume_.find(tet.volume);
    mesh.region.push_back(group == group_of_volume_.end() ? 0 : group->second);
  }
  return mesh;
}

void GmshReader::sortNodes() {
  std::sort(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) { return a.tag < b.tag; });
  const auto twice =
      std::adjacent_find(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) { return a.tag == b.tag; });
  if (twice != nodes_.end()) file_.failFile("node tag " + std::to_string(twice->tag) + " twice", "unique node tags");
}

int GmshReader::findNode(Tag tag) const {
  const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), tag,
                                      [](const Node& node, Tag wanted) { return node.tag < wanted; });
  if (found == nodes_.end() || found->tag != tag) {
    file_.failFile("an element with node tag " + std::to_string(tag), "tags of the section $Nodes");
  }
  return static_cast<int>(found - nodes_.begin());
}

}  // namespace

TetMesh readGmsh(const std::string& path) {
  return GmshReader(path).read();
}

}  // namespace sinew
