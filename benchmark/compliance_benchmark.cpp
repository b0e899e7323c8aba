// Times factorisation and compliance of stiffness matrices against CHOLMOD with BLAS, in one run on one core, and
// compares both with dense LAPACK, refined.
// usage: compliance_benchmark [--list] [--threads N] [--dense-to DOFS] [--robot FILE] [MESH ...]
// --list: the instruction sets of this machine, no more; --dense-to: no dense factor for more unknowns; --robot: the
// matrix of a robot along z, its cables in the sparsity; MESH: further bodies, clamped at their lowest x. The
// instruction set is SINEW_ISA's; OPENBLAS_CORETYPE should say the same of BLAS. See scripts/benchmark

#include <cblas.h>
#include <cholmod.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "duration_sample.h"
#include "measuring.h"
#include "mesh/bar_mesh.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/linalg/supernodal_cholesky.h"
#include "sinew/mesh/embedding.h"
#include "sinew/mesh/read_mesh.h"
#include "sinew/mesh/surface.h"
#include "sinew/robot/robot_description.h"

extern "C" {
void dpotrf_(const char* triangle, const int* n, double* a, const int* stride, int* info);
void dtrsm_(const char* side, const char* triangle, const char* transposed, const char* unit, const int* m,
            const int* n, const double* alpha, const double* a, const int* a_stride, double* b, const int* b_stride);
}

namespace sinew {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kCables = 9, kViaPoints = 25, kEffectorRows = 3, kTriangles = 46;
constexpr int kMostRows = kCables + kEffectorRows + 3 * kTriangles;
constexpr double kSeconds = 1.5;  // spent on one line, at least
constexpr int kRepeats = 15;      // at least
constexpr int kTurn = 6;

double timeOf(const std::function<void()>& work) {
  const Clock::time_point begin = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double calcLowest(const TetMesh& mesh) {
  double lowest = mesh.nodes.front().x();
  for (const Vec3& node : mesh.nodes) lowest = std::min(lowest, node.x());
  return lowest;
}

std::vector<bool> clamp(const TetMesh& mesh) {
  std::vector<bool> fixed;
  const double lowest = calcLowest(mesh);
  for (const Vec3& node : mesh.nodes) fixed.push_back(node.x() < lowest + 1e-9);
  return fixed;
}

FemModel makeModel(const TetMesh& mesh, int threads) {
  const Material silicone = {calcLame(200e3, 0.3), 1000};
  return FemModel(mesh, std::vector<Material>(mesh.tets.size(), silicone), clamp(mesh), {}, threads);
}

/// The rows of a robot: cables along the body, the position of its tip, then the corners of triangles of its surface.
/// The first rows are those of a smaller robot.
class RobotRows {
 public:
  RobotRows(const TetMesh& mesh, const FemModel& fem) : mesh_(mesh), fem_(fem) {}

  BlockRows make(int count) {
    random_.seed(1);
    normal_.reset();
    BlockRows rows(kMostRows, 4 * kCables * kViaPoints + 4 * kEffectorRows + 9 * kTriangles);
    const TetMesh& mesh = mesh_;
    const PointLocator locator(mesh);
    Eigen::AlignedBox3d box;
    for (const Vec3& node : mesh.nodes) box.extend(node);
    for (int cable = 0; cable < kCables; ++cable) addCable(box, locator, cable, rows);
    addEffector(rows);
    const Surface surface = makeBoundarySurface(mesh);
    while (rows.rows() < count) addTriangle(surface, rows);
    BlockRows first(kMostRows, 4 * kCables * kViaPoints + 4 * kEffectorRows + 9 * kTriangles);
    for (int row = 0; row < count; ++row) {
      first.beginRow();
      for (const auto* entry = rows.begin(row); entry != rows.end(row); ++entry) {
        first.add(entry->block, entry->derivative);
      }
    }
    return first;
  }

 private:
  Vec3 makeDirection() { return Vec3(normal_(random_), normal_(random_), normal_(random_)).normalized(); }

  void add(int node, const Vec3& derivative, BlockRows& rows) const {
    if (fem_.freeIndex(node) >= 0) rows.add(fem_.freeIndex(node), derivative);
  }

  // To a third, two thirds or the end of the body, at an eighth of its width from its axis.
  void addCable(const Eigen::AlignedBox3d& box, const PointLocator& locator, int cable, BlockRows& rows) {
    rows.beginRow();
    const double angle = 2 * M_PI * (cable % 3) / 3, reach = (cable / 3 + 1) / 3.0;
    for (int k = 1; k <= kViaPoints; ++k) {
      Vec3 at = box.center();
      at.x() = box.min().x() + reach * box.sizes().x() * (k - 0.5) / kViaPoints;
      at.y() += box.sizes().y() / 8 * std::cos(angle);
      at.z() += box.sizes().z() / 8 * std::sin(angle);
      const EmbeddedPoint point = locator.locate(at).point;
      const Vec3 direction = makeDirection();
      for (int i = 0; i < 4; ++i) add(point.nodes[i], point.weights[i] * direction, rows);
    }
  }

  void addEffector(BlockRows& rows) const {
    const auto tip = std::max_element(mesh_.nodes.begin(), mesh_.nodes.end(),
                                      [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    for (int axis = 0; axis < kEffectorRows; ++axis) {
      rows.beginRow();
      add(static_cast<int>(tip - mesh_.nodes.begin()), Vec3::Unit(axis), rows);
    }
  }

  void addTriangle(const Surface& surface, BlockRows& rows) {
    const auto& triangle = surface.triangles[random_() % surface.triangles.size()];
    for (int axis = 0; axis < 3; ++axis) {
      rows.beginRow();
      for (const int node : triangle) add(node, Vec3::Unit(axis) / 3, rows);
    }
  }

  const TetMesh& mesh_;
  const FemModel& fem_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

MatX makeDense(const BlockRows& rows, int size) {
  MatX H = MatX::Zero(rows.rows(), size);
  for (int row = 0; row < rows.rows(); ++row) {
    for (const auto* entry = rows.begin(row); entry != rows.end(row); ++entry) {
      H.block<1, 3>(row, 3 * entry->block) += entry->derivative.transpose();
    }
  }
  return H;
}

/// H^T - A X, summed with more digits than a double has.
MatX calcResidual(const BlockMatrix& matrix, const MatX& H, const MatX& X) {
  const BlockPattern& pattern = matrix.pattern();
  const std::vector<int>& start = pattern.columnStart();
  MatX residual(X.rows(), X.cols());
  std::vector<long double> sum(static_cast<std::size_t>(X.rows()));
  for (int k = 0; k < X.cols(); ++k) {
    for (int i = 0; i < X.rows(); ++i) sum[i] = H(k, i);
    for (int j = 0; j < pattern.size(); ++j) {
      for (int e = start[j / 3]; e < start[j / 3 + 1]; ++e) {
        const BlockSlot slot = pattern.slot(pattern.rows()[e], j / 3);
        for (int r = 0; r < 3; ++r) {
          const int i = 3 * pattern.rows()[e] + r;
          const long double value = matrix.values()[slot.first + j % 3 * slot.stride + r];
          sum[i] -= value * X(j, k);
          if (pattern.rows()[e] != j / 3) sum[j] -= value * X(i, k);
        }
      }
    }
    for (int i = 0; i < X.rows(); ++i) residual(i, k) = static_cast<double>(sum[i]);
  }
  return residual;
}

/// W by dense LAPACK, refined until only rounding of the result is left.
MatX calcDenseCompliance(const BlockMatrix& matrix, const MatX& H) {
  constexpr int kRefinements = 3;
  MatX A = matrix.makeDense();
  const int n = static_cast<int>(A.rows()), r = static_cast<int>(H.rows());
  int info = 0;
  dpotrf_("L", &n, A.data(), &n, &info);
  if (info != 0) throw std::runtime_error("the stiffness matrix is not positive definite");
  const double one = 1;
  MatX X = MatX::Zero(n, r);
  for (int pass = 0; pass < kRefinements; ++pass) {
    MatX step = calcResidual(matrix, H, X);
    for (const char* transposed : {"N", "T"}) {
      dtrsm_("L", "L", transposed, "N", &n, &r, &one, A.data(), &n, step.data(), &n);
    }
    X += step;
  }
  return H * X;
}

/// CHOLMOD with one of its orderings, simplicial or supernodal: factor, forward solve, symmetric product.
class CholmodRival {
 public:
  CholmodRival(const BlockMatrix& matrix, int ordering, int kind) {
    cholmod_start(&common_);
    common_.nmethods = 1;
    common_.method[0].ordering = ordering;
    common_.postorder = 1;
    common_.supernodal = kind;
    common_.final_ll = 1;
    fill(matrix);
    factor_ = cholmod_analyze(&matrix_, &common_);
  }
  ~CholmodRival() {
    for (cholmod_dense** dense : {&solution_, &y_, &e_}) cholmod_free_dense(dense, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodRival(const CholmodRival&) = delete;
  CholmodRival& operator=(const CholmodRival&) = delete;

  /// The right-hand sides are permuted beforehand, which is to its advantage.
  void setRows(const MatX& H) {
    const int* order = static_cast<const int*>(factor_->Perm);
    right_.resize(H.cols(), H.rows());
    for (int i = 0; i < H.cols(); ++i) right_.row(i) = H.col(order[i]).transpose();
    compliance_.setZero(H.rows(), H.rows());
  }

  void run() {
    cholmod_factorize(&matrix_, factor_, &common_);
    cholmod_dense right{};
    right.nrow = right.d = static_cast<std::size_t>(right_.rows());
    right.ncol = static_cast<std::size_t>(right_.cols());
    right.nzmax = right.nrow * right.ncol;
    right.x = right_.data();
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(CHOLMOD_L, factor_, &right, nullptr, &solution_, nullptr, &y_, &e_, &common_);
    const int n = static_cast<int>(right_.rows()), r = static_cast<int>(right_.cols());
    cblas_dsyrk(CblasColMajor, CblasLower, CblasTrans, r, n, 1, static_cast<double*>(solution_->x), n, 0,
                compliance_.data(), r);
  }

  MatX compliance() const { return compliance_.selfadjointView<Eigen::Lower>(); }

 private:
  void fill(const BlockMatrix& matrix) {
    const BlockPattern& pattern = matrix.pattern();
    const std::vector<int>& start = pattern.columnStart();
    column_start_.push_back(0);
    for (int j = 0; j < pattern.size(); ++j) {
      for (int k = start[j / 3]; k < start[j / 3 + 1]; ++k) {
        const BlockSlot slot = pattern.slot(pattern.rows()[k], j / 3);
        for (int r = 0; r < 3; ++r) {
          const int i = 3 * pattern.rows()[k] + r;
          if (i < j) continue;
          row_.push_back(i);
          value_.push_back(matrix.values()[slot.first + j % 3 * slot.stride + r]);
        }
      }
      column_start_.push_back(static_cast<int>(row_.size()));
    }
    matrix_ = {};
    matrix_.nrow = matrix_.ncol = static_cast<std::size_t>(pattern.size());
    matrix_.nzmax = row_.size();
    matrix_.p = column_start_.data();
    matrix_.i = row_.data();
    matrix_.x = value_.data();
    matrix_.stype = -1;
    matrix_.itype = CHOLMOD_INT;
    matrix_.xtype = CHOLMOD_REAL;
    matrix_.dtype = CHOLMOD_DOUBLE;
    matrix_.sorted = matrix_.packed = 1;
  }

  cholmod_common common_;
  cholmod_sparse matrix_;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense *solution_ = nullptr, *y_ = nullptr, *e_ = nullptr;
  std::vector<int> column_start_, row_;
  std::vector<double> value_;
  MatX right_, compliance_;
};

/// The fastest of its ways for this matrix.
std::unique_ptr<CholmodRival> makeBestRival(const BlockMatrix& matrix, const MatX& H) {
  std::unique_ptr<CholmodRival> best;
  double best_time = 0;
  for (const int ordering : {CHOLMOD_AMD, CHOLMOD_METIS, CHOLMOD_NESDIS}) {
    for (const int kind : {CHOLMOD_SIMPLICIAL, CHOLMOD_SUPERNODAL}) {
      auto rival = std::make_unique<CholmodRival>(matrix, ordering, kind);
      rival->setRows(H);
      double time = 1e9;
      for (int i = 0; i < 4; ++i) time = std::min(time, timeOf([&] { rival->run(); }));
      if (best && time >= best_time) continue;
      best = std::move(rival);
      best_time = time;
    }
  }
  return best;
}

struct Options {
  int threads = 1;
  int dense_to = 20000;
  std::string robot;
  std::vector<std::string> meshes;
};

/// `mesh` is the model's, turned so that the body lies along x.
void run(const std::string& kind, const TetMesh& mesh, const FemModel& fem, const Options& options) {
  FemData data(fem);
  assemble(fem, fem.rest(), Tangent::kExact, data);
  const BlockMatrix matrix = data.tangent;
  RobotRows robot_rows(mesh, fem);
  MatX dense;
  const bool has_dense = fem.size() <= options.dense_to;
  if (has_dense) dense = calcDenseCompliance(matrix, makeDense(robot_rows.make(kMostRows), fem.size()));
  for (const int count : {12, 87, kMostRows}) {
    const BlockRows rows = robot_rows.make(count);
    const MatX H = makeDense(rows, fem.size());
    const auto rival = makeBestRival(matrix, H);
    SupernodalCholesky cholesky(fem.factor(), count, options.threads);
    const VecX load = VecX::Ones(fem.size());
    MatX compliance(count, count);
    VecX motion(count);
    DurationSample assembly, factor, condense, theirs;
    const Clock::time_point begin = Clock::now();
    // In turns of some cycles each, of which the first finds the other's data in the caches and does not count.
    while (theirs.size() < kRepeats || std::chrono::duration<double>(Clock::now() - begin).count() < kSeconds) {
      for (int k = 0; k < kTurn; ++k) {
        const double assembled = timeOf([&] { assemble(fem, fem.rest(), Tangent::kExact, data); });
        const double factorised = timeOf([&] { cholesky.factorise(data.tangent); });
        const double condensed = timeOf([&] { cholesky.condense(rows, load, compliance, motion); });
        if (k == 0) continue;
        assembly.add(assembled);
        factor.add(factorised);
        condense.add(condensed);
      }
      for (int k = 0; k < kTurn; ++k) {
        const double time = timeOf([&] { rival->run(); });
        if (k > 0) theirs.add(time);
      }
    }
    const double factor_ms = 1e3 * factor.calcQuantile(0.5), condense_ms = 1e3 * condense.calcQuantile(0.5);
    const double ours_ms = factor_ms + condense_ms, cholmod_ms = 1e3 * theirs.calcQuantile(0.5);
    const double assembly_ms = 1e3 * assembly.calcQuantile(0.5);
    std::printf(
        "scene=compliance dofs=%d rows=%d mesh=%s isa=%s threads=%d cholmod_ms=%.3f ours_ms=%.3f ratio=%.2f "
        "factor_ms=%.3f "
        "condense_ms=%.3f assembly_ms=%.3f assembly_percent=%.1f",
        fem.size(), count, kind.c_str(), nameOf(chooseInstructionSet()), options.threads, cholmod_ms, ours_ms,
        cholmod_ms / ours_ms, factor_ms, condense_ms, assembly_ms, 100 * assembly_ms / ours_ms);
    if (has_dense) {
      const MatX W = dense.topLeftCorner(count, count);
      std::printf(" error=%.2e cholmod_error=%.2e", (compliance - W).norm() / W.norm(),
                  (rival->compliance() - W).norm() / W.norm());
    }
    std::printf("\n");
    std::fflush(stdout);
  }
}

void run(const std::string& kind, const TetMesh& mesh, const Options& options) {
  run(kind, mesh, makeModel(mesh, options.threads), options);
}

void runRobot(const Options& options) {
  RobotDescription description = readRobotDescription(options.robot);
  description.control.threads = options.threads;
  const RobotModel robot(description);
  TetMesh turned = robot.mesh();
  for (Vec3& node : turned.nodes) node = Vec3(node.z(), node.x(), node.y());
  run("trunk", turned, robot.fem(), options);
}

Options readOptions(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--dense-to" && i + 1 < argc) {
      options.dense_to = std::stoi(argv[++i]);
    } else if (argument == "--threads" && i + 1 < argc) {
      options.threads = std::stoi(argv[++i]);
    } else if (argument == "--robot" && i + 1 < argc) {
      options.robot = argv[++i];
    } else {
      options.meshes.push_back(argument);
    }
  }
  return options;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  using namespace sinew;
  try {
    if (argc == 2 && argv[1] == std::string("--list")) {
      for (const InstructionSet set : findInstructionSets()) std::printf("%s\n", nameOf(set));
      return 0;
    }
    const Options options = readOptions(argc, argv);
    if (options.threads == 1) pinToOneCore();
    for (const auto& [nx, ny] : {std::pair(33, 3), std::pair(60, 5), std::pair(100, 6)}) {
      run("bar", makeBarMesh(Vec3(0.3, 0.03, 0.03), nx, ny, ny), options);
    }
    if (!options.robot.empty()) runRobot(options);
    for (const std::string& file : options.meshes) run("gmsh", readMesh(file, 1), options);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compliance_benchmark: %s\n", error.what());
    return 1;
  }
}
