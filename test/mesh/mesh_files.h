#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "sinew/common/config_error.h"
#include "sinew/mesh/file_cursor.h"
#include "sinew/mesh/tet_mesh.h"

namespace sinew {

/// A folder of its own that is removed at the end; in memory where the system has such a place.
class TempFolder {
 public:
  TempFolder() {
    std::random_device random;
    const std::string name = "sinew_mesh_" + std::to_string(random());
    std::error_code error;
    folder_ = std::filesystem::path("/dev/shm") / name;
    if (std::filesystem::create_directory(folder_, error)) return;
    folder_ = std::filesystem::temp_directory_path() / name;
    std::filesystem::create_directory(folder_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

/// Builds a file whose numbers are text or binary.
class FileBuilder {
 public:
  enum class Numbers { kText, kLittleEndian, kBigEndian };
  explicit FileBuilder(Numbers numbers, std::string line_end = "\n") : numbers_(numbers), line_end_(line_end) {}

  FileBuilder& line(const std::string& text = "") {
    bytes_ += text + line_end_;
    return *this;
  }

  template <typename T>
  FileBuilder& number(T value) {
    if (numbers_ == Numbers::kText) return text(value);
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if ((numbers_ == Numbers::kLittleEndian) != isLittleEndian()) std::reverse(raw, raw + sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }

  const std::string& bytes() const { return bytes_; }

 private:
  template <typename T>
  FileBuilder& text(T value) {
    std::ostringstream stream;
    stream.precision(17);
    stream << value << ' ';
    bytes_ += stream.str();
    return *this;
  }

  Numbers numbers_;
  std::string line_end_;
  std::string bytes_;
};

struct VtkOptions {
  bool binary = false;
  double version = 2.0;
  bool float_points = false;
  enum class Region { kNone, kScalars, kField } region = Region::kNone;
  bool float_region = false;
  std::string line_end = "\n";
};

/// A vertex, a line, a triangle, a pyramid and then the tetrahedra, with a second triangle after the first of them.
class VtkBuilder {
 public:
  VtkBuilder(const TetMesh& mesh, const VtkOptions& options)
      : mesh_(mesh),
        options_(options),
        file_(options.binary ? FileBuilder::Numbers::kBigEndian : FileBuilder::Numbers::kText, options.line_end) {
    add(1, {0});
    add(3, {0, 1});
    add(5, {0, 1, 2});
    add(14, {0, 1, 2, 3, 4});
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      add(10, std::vector<int>(mesh.tets[t].begin(), mesh.tets[t].end()), mesh.region[t]);
      if (t == 0) add(5, {1, 2, 3});
    }
  }

  std::string build() {
    writeHeader();
    writePoints();
    if (options_.version < 5) {
      writeCounts();
    } else {
      writeOffsets();
    }
    writeTypes();
    writePointData();
    writeCellData();
    return file_.bytes();
  }

 private:
  struct Cell {
    int type;
    std::vector<int> points;
    int region;
  };

  void add(int type, const std::vector<int>& points, int region = -1) { cells_.push_back({type, points, region}); }
  std::string cellCount() const { return std::to_string(cells_.size()); }
  std::size_t connectivitySize() const {
    std::size_t size = 0;
    for (const Cell& cell : cells_) size += cell.points.size();
    return size;
  }

  void writeHeader() {
    std::ostringstream version;
    version.precision(1);
    version << std::fixed << options_.version;
    file_.line("# vtk DataFile Version " + version.str()).line("a title, POINTS 3 float");
    file_.line(options_.binary ? "BINARY" : "ASCII").line("DATASET UNSTRUCTURED_GRID");
    file_.line("FIELD FieldData 1").line("TIME 1 1 double").number(0.5).line();
  }

  void writePoints() {
    file_.line("POINTS " + std::to_string(mesh_.nodes.size()) + (options_.float_points ? " float" : " double"));
    for (const Vec3& node : mesh_.nodes) {
      for (int axis = 0; axis < 3; ++axis) {
        if (options_.float_points) {
          file_.number(static_cast<float>(node[axis]));
        } else {
          file_.number(node[axis]);
        }
      }
    }
    file_.line();
    file_.line("METADATA").line("INFORMATION 1").line("NAME L2_NORM_RANGE LOCATION vtkDataArray").line("DATA 2 0 1");
    file_.line();
  }

  void writeCounts() {
    file_.line("CELLS " + cellCount() + " " + std::to_string(cells_.size() + connectivitySize()));
    for (const Cell& cell : cells_) {
      file_.number(static_cast<std::int32_t>(cell.points.size()));
      for (const int point : cell.points) file_.number(static_cast<std::int32_t>(point));
    }
    file_.line();
  }

  void writeOffsets() {
    file_.line("CELLS " + std::to_string(cells_.size() + 1) + " " + std::to_string(connectivitySize()));
    file_.line("OFFSETS vtktypeint64");
    std::int64_t offset = 0;
    file_.number(offset);
    for (const Cell& cell : cells_) file_.number(offset += static_cast<std::int64_t>(cell.points.size()));
    file_.line().line("METADATA").line("INFORMATION 0").line();
    file_.line("CONNECTIVITY vtktypeint64");
    for (const Cell& cell : cells_) {
      for (const int point : cell.points) file_.number(static_cast<std::int64_t>(point));
    }
    file_.line();
  }

  void writeTypes() {
    file_.line("CELL_TYPES " + cellCount());
    for (const Cell& cell : cells_) file_.number(static_cast<std::int32_t>(cell.type));
    file_.line().line();
  }

  void writePointData() {
    file_.line("POINT_DATA " + std::to_string(mesh_.nodes.size()));
    file_.line("SCALARS region int 1").line("LOOKUP_TABLE default");
    for (std::size_t i = 0; i < mesh_.nodes.size(); ++i) file_.number(std::int32_t{99});
    file_.line().line("VECTORS force float");
    for (std::size_t i = 0; i < 3 * mesh_.nodes.size(); ++i) file_.number(1.5f);
    file_.line();
  }

  void writeCellData() {
    file_.line("CELL_DATA " + cellCount()).line("COLOR_SCALARS colour 3");
    for (std::size_t i = 0; i < 3 * cells_.size(); ++i) {
      if (options_.binary) {
        file_.number('\n');
      } else {
        file_.number(0.25);
      }
    }
    file_.line();
    const std::string type = options_.float_region ? "float" : "int";
    if (options_.region == VtkOptions::Region::kScalars) {
      file_.line("SCALARS region " + type).line("LOOKUP_TABLE default");
      writeRegion();
    } else if (options_.region == VtkOptions::Region::kField) {
      file_.line("FIELD FieldData 2").line("quality 2 " + cellCount() + " unsigned_short");
      for (std::size_t i = 0; i < 2 * cells_.size(); ++i) file_.number(std::uint16_t{10});
      file_.line().line("METADATA").line("COMPONENT_NAMES").line("a").line("b").line();
      file_.line("region 1 " + cellCount() + " " + type);
      writeRegion();
    }
  }

  void writeRegion() {
    for (const Cell& cell : cells_) {
      if (options_.float_region) {
        file_.number(static_cast<float>(cell.region));
      } else {
        file_.number(static_cast<std::int32_t>(cell.region));
      }
    }
    file_.line();
  }

  const TetMesh& mesh_;
  VtkOptions options_;
  FileBuilder file_;
  std::vector<Cell> cells_;
};

inline std::string makeVtkFile(const TetMesh& mesh, const VtkOptions& options) {
  return VtkBuilder(mesh, options).build();
}

struct GmshOptions {
  FileBuilder::Numbers numbers = FileBuilder::Numbers::kText;
  std::string line_end = "\n";
};

/// Node i has the tag 10 + 3 i; the second half of the nodes comes first. Tetrahedra of region r lie in volume r + 100,
/// in physical group r if r > 0. A point, a curve, a surface and sections of other kinds are in the file too.
class GmshBuilder {
 public:
  GmshBuilder(const TetMesh& mesh, const GmshOptions& options)
      : mesh_(mesh), binary_(options.numbers != FileBuilder::Numbers::kText), file_(options.numbers, options.line_end) {
    regions_ = mesh.region;
    std::sort(regions_.begin(), regions_.end());
    regions_.erase(std::unique(regions_.begin(), regions_.end()), regions_.end());
  }

  std::string build() {
    file_.line("$MeshFormat").line(std::string("4.1 ") + (binary_ ? "1" : "0") + " 8");
    if (binary_) integer(1).line();
    file_.line("$EndMeshFormat").line("$PhysicalNames").line("1").line("3 2 \"body\"").line("$EndPhysicalNames");
    writeEntities();
    file_.line("$PartitionedEntities").line("\x01 nothing that is understood \x02").line("$EndPartitionedEntities");
    writeNodes();
    writeElements();
    return file_.bytes();
  }

 private:
  FileBuilder& integer(int value) { return file_.number(static_cast<std::int32_t>(value)); }
  FileBuilder& size(std::size_t value) { return file_.number(static_cast<std::uint64_t>(value)); }
  std::size_t tagOf(int node) const { return 10 + 3 * static_cast<std::size_t>(node); }
  void endText() {
    if (!binary_) file_.line();
  }

  void writeEntity(int tag, int reals, const std::vector<int>& groups, const std::vector<int>& bounds) {
    integer(tag);
    for (int i = 0; i < reals; ++i) file_.number(0.25 * i);
    size(groups.size());
    for (const int group : groups) integer(group);
    if (reals > 3) {
      size(bounds.size());
      for (const int bound : bounds) integer(bound);
    }
    endText();
  }

  void writeEntities() {
    file_.line("$Entities");
    size(1), size(1), size(1), size(regions_.size());
    endText();
    writeEntity(1, 3, {}, {});
    writeEntity(1, 6, {4}, {1, -1});
    writeEntity(1, 6, {}, {1});
    for (const int region : regions_) {
      writeEntity(region + 100, 6, region > 0 ? std::vector<int>{region, 77} : std::vector<int>{}, {1});
    }
    if (binary_) file_.line();
    file_.line("$EndEntities");
  }

  void writeNodeBlock(int dimension, bool parametric, int begin, int end) {
    integer(dimension), integer(1), integer(parametric ? 1 : 0);
    size(static_cast<std::size_t>(end - begin));
    endText();
    for (int i = begin; i < end; ++i) size(tagOf(i));
    endText();
    for (int i = begin; i < end; ++i) {
      for (int axis = 0; axis < 3; ++axis) file_.number(mesh_.nodes[static_cast<std::size_t>(i)][axis]);
      for (int k = 0; parametric && k < dimension; ++k) file_.number(0.5);
      endText();
    }
  }

  void writeNodes() {
    const int count = static_cast<int>(mesh_.nodes.size());
    file_.line("$Nodes");
    size(3), size(mesh_.nodes.size()), size(tagOf(0)), size(tagOf(count - 1));
    endText();
    writeNodeBlock(3, false, count / 2, count);
    writeNodeBlock(0, false, 0, 0);
    writeNodeBlock(2, true, 0, count / 2);
    if (binary_) file_.line();
    file_.line("$EndNodes");
  }

  void writeElement(std::size_t tag, const std::vector<int>& nodes) {
    size(tag);
    for (const int node : nodes) size(tagOf(node));
    endText();
  }

  void writeBlockHeader(int dimension, int entity, int type, std::size_t count) {
    integer(dimension), integer(entity), integer(type), size(count);
    endText();
  }

  void writeElements() {
    file_.line("$Elements");
    size(3 + regions_.size()), size(3 + mesh_.tets.size()), size(1), size(3 + mesh_.tets.size());
    endText();
    writeBlockHeader(0, 1, 15, 1);
    writeElement(1, {0});
    writeBlockHeader(1, 1, 1, 1);
    writeElement(2, {0, 1});
    std::size_t tag = 3;
    for (const int region : regions_) {
      const auto count = static_cast<std::size_t>(std::count(mesh_.region.begin(), mesh_.region.end(), region));
      writeBlockHeader(3, region + 100, 4, count);
      for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
        if (mesh_.region[t] == region) {
          writeElement(tag++, std::vector<int>(mesh_.tets[t].begin(), mesh_.tets[t].end()));
        }
      }
    }
    writeBlockHeader(2, 1, 2, 1);
    writeElement(tag, {0, 1, 2});
    if (binary_) file_.line();
    file_.line("$EndElements");
  }

  const TetMesh& mesh_;
  bool binary_;
  FileBuilder file_;
  std::vector<int> regions_;
};

inline std::string makeGmshFile(const TetMesh& mesh, const GmshOptions& options) {
  return GmshBuilder(mesh, options).build();
}

/// Expects a ConfigError whose message holds every one of `words`.
inline void expectConfigError(const std::function<void()>& action, std::initializer_list<std::string> words) {
  try {
    action();
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    for (const std::string& word : words) {
      EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' is not in: " << message;
    }
    return;
  }
  ADD_FAILURE() << "no ConfigError was thrown";
}

/// `text` with the first occurrence of `from`, which must be there, replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "'" << from << "' is not in the file";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace sinew
