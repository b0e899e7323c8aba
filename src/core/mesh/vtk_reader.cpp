#include "sinew/mesh/vtk_reader.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "sinew/mesh/file_cursor.h"

namespace sinew {
namespace {

constexpr int kTetrahedron = 10;
constexpr int kQuadraticTetrahedron = 24;
constexpr int kLagrangeTetrahedron = 71;
constexpr double kNewestVersion = 5.1;
/// From this version on cells are stored as offsets and connectivity.
constexpr double kOffsetsVersion = 5.0;
constexpr std::int64_t kMostComponents = 1 << 16;
constexpr const char* kHowToConvert = " (scripts/convert_mesh converts other files)";

using Values = std::vector<double>;  // integers too: exact below 2^53, and indices are far below

/// Reads one number of a VTK data type.
struct Scalar {
  std::size_t bytes;
  double (*read)(FileCursor& file, bool swap, const char* expected);
};

template <typename T>
Scalar makeScalar() {
  return {sizeof(T), [](FileCursor& file, bool swap, const char* expected) {
            return static_cast<double>(file.readBinary<T>(swap, expected));
          }};
}

const std::unordered_map<std::string, Scalar>& scalars() {
  static const std::unordered_map<std::string, Scalar> kScalars = {
      {"char", makeScalar<std::int8_t>()},
      {"signed_char", makeScalar<std::int8_t>()},
      {"unsigned_char", makeScalar<std::uint8_t>()},
      {"short", makeScalar<std::int16_t>()},
      {"unsigned_short", makeScalar<std::uint16_t>()},
      {"int", makeScalar<std::int32_t>()},
      {"unsigned_int", makeScalar<std::uint32_t>()},
      {"vtkidtype", makeScalar<std::int32_t>()},
      {"long", makeScalar<std::int64_t>()},
      {"unsigned_long", makeScalar<std::uint64_t>()},
      {"vtktypeint64", makeScalar<std::int64_t>()},
      {"vtktypeuint64", makeScalar<std::uint64_t>()},
      {"float", makeScalar<float>()},
      {"double", makeScalar<double>()},
  };
  return kScalars;
}

std::string toLower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

bool isIndex(double value, std::size_t end) {
  return value >= 0 && value < static_cast<double>(end) && value <= std::numeric_limits<int>::max() &&
         value == std::floor(value);
}

class VtkReader {
 public:
  explicit VtkReader(const std::string& path) : file_(path) {}

  TetMesh read() {
    readHeader();
    while (!file_.isAtEnd()) readSection();
    return makeMesh();
  }

 private:
  void readHeader();
  void readSection();
  void readPoints();
  void readCells();
  void readCellsWithCounts(std::int64_t cells, std::int64_t size);
  void readCellsWithOffsets(std::int64_t offsets, std::int64_t size);
  void readCellTypes();
  void beginAttributes(bool of_cells);
  bool readAttribute(const std::string& keyword);
  void readScalars();
  void readColors();
  void readTextureCoordinates();
  void readField();
  void readFieldArray();
  void skipLookupTable();
  void skipMetadata();
  void skipMetadataIfAny();

  Values readArray(const std::string& type, std::int64_t tuples, std::int64_t components, const char* expected);
  Values readTypedArray(std::int64_t tuples, std::int64_t components, const char* expected);
  void keepRegion(const std::string& name, Values values);
  int toIndex(double value, std::size_t end, const char* expected) const;

  TetMesh makeMesh() const;
  void addTet(TetMesh& mesh, std::size_t cell) const;
  int calcRegion(std::size_t cell) const;

  FileCursor file_;
  bool is_binary_ = false;
  double version_ = 0;
  std::vector<Vec3> points_;
  bool has_points_ = false;
  std::vector<std::size_t> offsets_ = {0};  // cell c has the points connectivity_[offsets_[c] .. offsets_[c + 1])
  Values connectivity_;
  std::vector<int> types_;
  bool in_cell_data_ = false;
  std::int64_t tuples_ = 0;  // of the arrays in this attribute section
  Values region_;            // one value per cell, or empty
};

void VtkReader::readHeader() {
  if (file_.peekWord() != "#") file_.fail("another beginning", "a VTK legacy file: '# vtk DataFile Version 3.0'");
  file_.expectWord("#");
  file_.expectWord("vtk");
  file_.expectWord("DataFile");
  file_.expectWord("Version");
  version_ = file_.readReal("a version number");
  if (!(version_ >= 1.0 && version_ < kNewestVersion + 0.05)) {
    file_.fail("version " + std::to_string(version_), std::string("1.0 to 5.1") + kHowToConvert);
  }
  file_.readLine();
  file_.readLine();  // title
  const std::string format = toLower(file_.readWord("ASCII or BINARY"));
  if (format != "ascii" && format != "binary") file_.fail("'" + format + "'", "ASCII or BINARY");
  is_binary_ = format == "binary";
  if (toLower(file_.readWord("DATASET")) != "dataset") file_.fail("another keyword", "DATASET");
  const std::string dataset = toLower(file_.readWord("UNSTRUCTURED_GRID"));
  if (dataset != "unstructured_grid") {
    file_.fail("data set '" + dataset + "'", std::string("UNSTRUCTURED_GRID") + kHowToConvert);
  }
}

void VtkReader::readSection() {
  const std::string keyword = toLower(file_.readWord("a keyword"));
  if (keyword == "points") return readPoints();
  if (keyword == "cells") return readCells();
  if (keyword == "cell_types") return readCellTypes();
  if (keyword == "cell_data") return beginAttributes(true);
  if (keyword == "point_data") return beginAttributes(false);
  if (keyword == "field") return readField();
  if (keyword == "metadata") return skipMetadata();
  if (!readAttribute(keyword)) file_.fail("'" + keyword.substr(0, 40) + "'", "a keyword of the VTK legacy format");
}

void VtkReader::readPoints() {
  const std::int64_t count = file_.readInteger("the number of points");
  if (has_points_) file_.fail("POINTS a second time", "one POINTS section");
  const Values values = readTypedArray(count, 3, "point coordinates");
  points_.resize(values.size() / 3);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    points_[i] = Vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
  }
  has_points_ = true;
}

void VtkReader::readCells() {
  const std::int64_t first = file_.readInteger("the number of cells");
  const std::int64_t second = file_.readInteger("the size of the cell list");
  if (offsets_.size() > 1) file_.fail("CELLS a second time", "one CELLS section");
  if (version_ < kOffsetsVersion) {
    readCellsWithCounts(first, second);
  } else {
    readCellsWithOffsets(first, second);
  }
}

/// Up to version 4.2: one list of (count, point, point, ...).
void VtkReader::readCellsWithCounts(std::int64_t cells, std::int64_t size) {
  const Values list = readArray("int", size, 1, "the cell list");
  std::size_t at = 0;
  for (std::int64_t cell = 0; cell < cells; ++cell) {
    if (at >= list.size()) {
      file_.fail("a cell list of " + std::to_string(size) + " that ends early", "every cell in it");
    }
    const int count = toIndex(list[at], list.size() - at, "a number of points that fits in the cell list");
    const auto begin = list.begin() + static_cast<std::ptrdiff_t>(at + 1);
    connectivity_.insert(connectivity_.end(), begin, begin + count);
    offsets_.push_back(connectivity_.size());
    at += static_cast<std::size_t>(count) + 1;
  }
  if (at != list.size()) file_.fail("a cell list longer than its cells", std::to_string(at) + " entries");
}

/// From version 5.0: OFFSETS (one more than cells) and CONNECTIVITY.
void VtkReader::readCellsWithOffsets(std::int64_t offsets, std::int64_t size) {
  file_.expectWord("OFFSETS");
  const Values begins = readTypedArray(offsets, 1, "cell offsets");
  skipMetadataIfAny();
  file_.expectWord("CONNECTIVITY");
  connectivity_ = readTypedArray(size, 1, "cell connectivity");
  offsets_.clear();
  for (const double begin : begins) {
    const int offset = toIndex(begin, connectivity_.size() + 1, "cell offsets within the connectivity");
    const std::size_t lowest = offsets_.empty() ? 0 : offsets_.back();
    if (static_cast<std::size_t>(offset) < lowest) file_.fail("cell offsets that fall", "rising cell offsets");
    offsets_.push_back(static_cast<std::size_t>(offset));
  }
  if (offsets_.empty()) offsets_.push_back(0);
}

void VtkReader::readCellTypes() {
  const std::int64_t count = file_.readInteger("the number of cell types");
  if (!types_.empty()) file_.fail("CELL_TYPES a second time", "one CELL_TYPES section");
  for (const double type : readArray("int", count, 1, "cell types")) {
    types_.push_back(toIndex(type, 256, "a cell type"));
  }
}

void VtkReader::beginAttributes(bool of_cells) {
  in_cell_data_ = of_cells;
  tuples_ = file_.readInteger("the number of tuples");
}

/// Reads the attribute that `keyword` begins; false if it is none.
bool VtkReader::readAttribute(const std::string& keyword) {
  static const std::unordered_map<std::string, int> kComponents = {
      {"vectors", 3},    {"normals", 3},      {"tensors", 9},   {"tensors6", 6},
      {"global_ids", 1}, {"pedigree_ids", 1}, {"edge_flags", 1}};
  if (keyword == "scalars") {
    readScalars();
  } else if (keyword == "color_scalars") {
    readColors();
  } else if (keyword == "texture_coordinates") {
    readTextureCoordinates();
  } else if (keyword == "lookup_table") {
    skipLookupTable();
  } else if (kComponents.count(keyword) > 0) {
    file_.readWord("the name of an array");
    readTypedArray(tuples_, kComponents.at(keyword), "attribute values");
  } else {
    return false;
  }
  return true;
}

void VtkReader::readScalars() {
  const std::string name(file_.readWord("the name of an array"));
  const std::string type = toLower(file_.readWord("a data type"));
  const bool has_components = file_.hasWordOnLine();
  const std::int64_t components = has_components ? file_.readInteger("the number of components") : 1;
  file_.expectWord("LOOKUP_TABLE");
  file_.readWord("the name of a lookup table");
  Values values = readArray(type, tuples_, components, "scalars");
  if (components == 1) keepRegion(name, std::move(values));
}

/// Colours are bytes in a binary file and numbers from 0 to 1 in a text file.
void VtkReader::readColors() {
  file_.readWord("the name of an array");
  const std::int64_t components = file_.readInteger("the number of colour components");
  readArray(is_binary_ ? "unsigned_char" : "float", tuples_, components, "colours");
}

void VtkReader::skipLookupTable() {
  file_.readWord("the name of a lookup table");
  const std::int64_t size = file_.readInteger("the size of the lookup table");
  readArray(is_binary_ ? "unsigned_char" : "float", size, 4, "colours");
}

void VtkReader::readTextureCoordinates() {
  file_.readWord("the name of an array");
  const std::int64_t components = file_.readInteger("the number of texture coordinates");
  readTypedArray(tuples_, components, "texture coordinates");
}

void VtkReader::readField() {
  file_.readWord("the name of a field");
  const std::int64_t arrays = file_.readInteger("the number of arrays");
  for (std::int64_t i = 0; i < arrays; ++i) readFieldArray();
}

void VtkReader::readFieldArray() {
  skipMetadataIfAny();
  const std::string name(file_.readWord("the name of an array"));
  const std::int64_t components = file_.readInteger("the number of components");
  const std::int64_t tuples = file_.readInteger("the number of tuples");
  Values values = readTypedArray(tuples, components, "array values");
  if (components == 1) keepRegion(name, std::move(values));
}

/// METADATA ends at an empty line.
void VtkReader::skipMetadata() {
  file_.readLine();
  while (file_.hasWordOnLine()) file_.readLine();
}

void VtkReader::skipMetadataIfAny() {
  if (toLower(file_.peekWord()) != "metadata") return;
  file_.readWord("METADATA");
  skipMetadata();
}

Values VtkReader::readTypedArray(std::int64_t tuples, std::int64_t components, const char* expected) {
  const std::string type = toLower(file_.readWord("a data type"));
  return readArray(type, tuples, components, expected);
}

Values VtkReader::readArray(const std::string& type, std::int64_t tuples, std::int64_t components,
                            const char* expected) {
  const auto scalar = scalars().find(type);
  if (scalar == scalars().end()) {
    file_.fail("data type '" + type.substr(0, 40) + "'", "a number type such as float or int");
  }
  if (components < 1 || components > kMostComponents) {
    file_.fail(std::to_string(components) + " components", "1 to " + std::to_string(kMostComponents));
  }
  const auto width = static_cast<std::size_t>(components);
  const std::size_t bytes = is_binary_ ? scalar->second.bytes : 2;  // text: a digit and a space
  const std::size_t count = width * file_.checkCount(tuples, width * bytes, expected);
  Values values;
  values.reserve(count);
  if (is_binary_) file_.readLine();
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(is_binary_ ? scalar->second.read(file_, isLittleEndian(), expected) : file_.readReal(expected));
  }
  return values;
}

void VtkReader::keepRegion(const std::string& name, Values values) {
  if (in_cell_data_ && name == "region") region_ = std::move(values);
}

int VtkReader::toIndex(double value, std::size_t end, const char* expected) const {
  if (!isIndex(value, end)) {
    file_.fail(std::to_string(value), std::string(expected) + ", an integer below " + std::to_string(end));
  }
  return static_cast<int>(value);
}

TetMesh VtkReader::makeMesh() const {
  const std::size_t cells = offsets_.size() - 1;
  if (types_.size() != cells) {
    file_.failFile(std::to_string(cells) + " cells with " + std::to_string(types_.size()) + " cell types",
                   "as many types as cells");
  }
  if (!region_.empty() && region_.size() != cells) {
    file_.failFile("cell array 'region' with " + std::to_string(region_.size()) + " values",
                   "one for each of the " + std::to_string(cells) + " cells");
  }
  TetMesh mesh;
  mesh.nodes = points_;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (types_[cell] == kQuadraticTetrahedron || types_[cell] == kLagrangeTetrahedron) {
      file_.failFile("second-order tetrahedra", std::string("linear ones, of 4 nodes") + kHowToConvert);
    }
    if (types_[cell] == kTetrahedron) addTet(mesh, cell);
  }
  return mesh;
}

void VtkReader::addTet(TetMesh& mesh, std::size_t cell) const {
  if (offsets_[cell + 1] - offsets_[cell] != 4) {
    file_.failFile("cell " + std::to_string(cell) + ", a tetrahedron of " +
                       std::to_string(offsets_[cell + 1] - offsets_[cell]) + " points",
                   "4 points");
  }
  std::array<int, 4> tet;
  for (std::size_t i = 0; i < 4; ++i) {
    const double point = connectivity_[offsets_[cell] + i];
    if (!isIndex(point, points_.size())) {
      file_.failFile("cell " + std::to_string(cell) + " with point " + std::to_string(point),
                     "integers below the " + std::to_string(points_.size()) + " points");
    }
    tet[i] = static_cast<int>(point);
  }
  mesh.tets.push_back(tet);
  mesh.region.push_back(calcRegion(cell));
}

int VtkReader::calcRegion(std::size_t cell) const {
  if (region_.empty()) return 0;
  const double value = region_[cell];
  if (!(std::abs(value) <= std::numeric_limits<int>::max() && value == std::floor(value))) {
    file_.failFile("cell array 'region' with the value " + std::to_string(value), "integers");
  }
  return static_cast<int>(value);
}

}  // namespace

TetMesh readVtk(const std::string& path) {
  return VtkReader(path).read();
}

}  // namespace sinew
