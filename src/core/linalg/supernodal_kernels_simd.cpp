// One register tile does nearly all of the work: up to three vectors of rows times a few columns, C - A B^T, kept in
// registers while the depth is walked, and finished there by the triangular solve where one is due. BLAS on blocks this
// small spends its time on the call.

#include "sinew/linalg/simd.h"
#include "sinew/linalg/supernodal_kernels.h"

#define SINEW_INLINE inline __attribute__((always_inline))
#define SINEW_INLINE_CALL __attribute__((always_inline))
#define SINEW_UNROLL _Pragma("GCC unroll 16")

namespace sinew {
namespace SINEW_ISA {
namespace {

constexpr int kWidth = Simd::kWidth;
constexpr int kVectors = 3;                    // of rows in a tile: whole nodes for every width
constexpr int kColumns = kWidth == 8 ? 9 : 3;  // as many as the registers hold
constexpr int kRows = kVectors * kWidth;
constexpr int kRowNodes = kRows / 3;
constexpr int kMaxRowVectors = 64 * 8;  // of the half solutions
/// A product is summed from zero and C added last: beside the large entries of C every term would be rounded more. With
/// the sixteen registers of SSE2 compilers spill some of it then.
constexpr bool kAddsLast = kWidth > 2;
constexpr int kSequence[kVectors] = {0, kWidth, 2 * kWidth};

/// Rows of a tile: vectors at these offsets, the last one with so many rows in use.
struct RowVectors {
  const int* offset;
  int last;
};

/// Columns of a tile: every third one's address, the two after it a stride apart.
struct ColumnTriples {
  int stride;
  double* first[kColumns / 3] = {};

  explicit ColumnTriples(int column_stride) : stride(column_stride) {}
  ColumnTriples(double* begin, int column_stride) : stride(column_stride) {
    SINEW_UNROLL for (int i = 0; i < kColumns / 3; ++i) first[i] = begin + 3 * i * stride;
  }
  double* operator[](int column) const { return first[column / 3] + column % 3 * stride; }
};

template <int V, int C>
struct Tile {
  Simd sum[C][V];

  SINEW_INLINE void clear() {
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      SINEW_UNROLL for (int v = 0; v < V; ++v) sum[j][v] = Simd::fill(0);
    }
  }

  SINEW_INLINE void load(const ColumnTriples& columns, const RowVectors& rows) {
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      const double* column = columns[j];
      SINEW_UNROLL for (int v = 0; v + 1 < V; ++v) sum[j][v] = Simd::load(column + rows.offset[v]);
      column += rows.offset[V - 1];
      sum[j][V - 1] = rows.last == kWidth ? Simd::load(column) : Simd::loadHead(column, rows.last);
    }
  }

  SINEW_INLINE void add(const ColumnTriples& columns, const RowVectors& rows) {
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      const double* column = columns[j];
      SINEW_UNROLL for (int v = 0; v + 1 < V; ++v) sum[j][v] = sum[j][v] + Simd::load(column + rows.offset[v]);
      column += rows.offset[V - 1];
      sum[j][V - 1] = sum[j][V - 1] + (rows.last == kWidth ? Simd::load(column) : Simd::loadHead(column, rows.last));
    }
  }

  SINEW_INLINE void store(const ColumnTriples& columns, const RowVectors& rows) const {
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      double* column = columns[j];
      SINEW_UNROLL for (int v = 0; v + 1 < V; ++v) sum[j][v].store(column + rows.offset[v]);
      column += rows.offset[V - 1];
      if (rows.last == kWidth) {
        sum[j][V - 1].store(column);
      } else {
        sum[j][V - 1].storeHead(column, rows.last);
      }
    }
  }

  /// sum -= A B^T: the rows of `a` at the vectors' offsets, C rows of `b` from its first.
  SINEW_INLINE void subtractProduct(const double* a, int a_stride, const int* offset, const double* b, int b_stride,
                                    int depth) {
    for (int k = 0; k < depth; ++k, a += a_stride, b += b_stride) {
      Simd row[V];
      SINEW_UNROLL for (int v = 0; v < V; ++v) row[v] = Simd::load(a + offset[v]);
      SINEW_UNROLL for (int j = 0; j < C; ++j) {
        const Simd factor = Simd::fill(b[j]);
        SINEW_UNROLL for (int v = 0; v < V; ++v) sum[j][v] = multiplySubtract(row[v], factor, sum[j][v]);
      }
    }
  }

  /// sum = C - A B^T
  SINEW_INLINE void takeFrom(const ColumnTriples& columns, const RowVectors& rows, const double* a, int a_stride,
                             const double* b, int b_stride, int depth) {
    if constexpr (kAddsLast) {
      clear();
    } else {
      load(columns, rows);
    }
    subtractProduct(a, a_stride, rows.offset, b, b_stride, depth);
    if constexpr (kAddsLast) add(columns, rows);
  }

  /// sum <- sum L^-T with a lower triangle L.
  SINEW_INLINE void solve(const double* triangle, int stride, const double* inverse_diagonal) {
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      const Simd inverse = Simd::fill(inverse_diagonal[j]);
      SINEW_UNROLL for (int v = 0; v < V; ++v) sum[j][v] = sum[j][v] * inverse;
      SINEW_UNROLL for (int i = j + 1; i < C; ++i) {
        const Simd factor = Simd::fill(triangle[i + j * stride]);
        SINEW_UNROLL for (int v = 0; v < V; ++v) sum[i][v] = multiplySubtract(sum[j][v], factor, sum[i][v]);
      }
    }
  }

  /// Adds the tile to nodes that lie apart: the i-th three rows at place[i].
  SINEW_INLINE void scatter(const ColumnTriples& columns, const int* place, int nodes) const {
    alignas(64) double buffer[C][V * kWidth];
    SINEW_UNROLL for (int j = 0; j < C; ++j) {
      SINEW_UNROLL for (int v = 0; v < V; ++v) sum[j][v].store(buffer[j] + v * kWidth);
    }
    for (int i = 0; i < nodes; ++i) {
      SINEW_UNROLL for (int j = 0; j < C; ++j) {
        double* to = columns[j] + place[i];
        const double* from = buffer[j] + 3 * i;
        to[0] += from[0];
        to[1] += from[1];
        to[2] += from[2];
      }
    }
  }
};

/// Calls `work` with the tile that has `vectors` x `columns`.
template <int V, typename Work>
SINEW_INLINE void withColumns(int columns, const Work& work) {
  if constexpr (kColumns == 9) {
    if (columns == 9) return work(Tile<V, 9>());
    if (columns == 6) return work(Tile<V, 6>());
  }
  return work(Tile<V, 3>());
}

template <typename Work>
SINEW_INLINE void withTile(int vectors, int columns, const Work& work) {
  if (vectors == 3) return withColumns<3>(columns, work);
  if (vectors == 2) return withColumns<2>(columns, work);
  return withColumns<1>(columns, work);
}

int smaller(int a, int b) {
  return a < b ? a : b;
}

void update(const double* source, int source_stride, int depth, const int* place, int nodes, int column_nodes,
            double* target, int target_stride) {
  for (int c = 0; c < column_nodes; c += kColumns / 3) {
    const int columns = smaller(kColumns / 3, column_nodes - c);
    for (int r = c; r < nodes; r += kRowNodes) {
      const int rows = smaller(kRowNodes, nodes - r);
      const int vectors = (3 * rows + kWidth - 1) / kWidth;
      const bool together = place[r + rows - 1] - place[r] == 3 * (rows - 1);
      ColumnTriples to(target_stride);
      for (int i = 0; i < columns; ++i) to.first[i] = target + place[c + i] * target_stride + (together ? place[r] : 0);
      withTile(vectors, 3 * columns, [&](auto tile) SINEW_INLINE_CALL {
        const RowVectors all = {kSequence, 3 * rows - (vectors - 1) * kWidth};
        if (together) {
          tile.takeFrom(to, all, source + 3 * r, source_stride, source + 3 * c, source_stride, depth);
          tile.store(to, all);
        } else {
          tile.clear();
          tile.subtractProduct(source + 3 * r, source_stride, kSequence, source + 3 * c, source_stride, depth);
          tile.scatter(to, place + r, rows);
        }
      });
    }
  }
}

/// The Cholesky factor of a small square, column by column.
template <int C>
SINEW_INLINE bool factoriseSquare(double* square, int stride, double* inverse_diagonal) {
  double a[C][C];
  SINEW_UNROLL for (int j = 0; j < C; ++j) {
    SINEW_UNROLL for (int i = j; i < C; ++i) a[j][i] = square[i + j * stride];
  }
  bool positive = true;
  SINEW_UNROLL for (int j = 0; j < C; ++j) {
    positive = positive && a[j][j] > 0;
    const double diagonal = __builtin_sqrt(a[j][j]);
    const double inverse = 1 / diagonal;
    inverse_diagonal[j] = inverse;
    a[j][j] = diagonal;
    SINEW_UNROLL for (int i = j + 1; i < C; ++i) a[j][i] *= inverse;
    SINEW_UNROLL for (int k = j + 1; k < C; ++k) {
      SINEW_UNROLL for (int i = k; i < C; ++i) a[k][i] -= a[j][k] * a[j][i];
    }
  }
  SINEW_UNROLL for (int j = 0; j < C; ++j) {
    SINEW_UNROLL for (int i = j; i < C; ++i) square[i + j * stride] = a[j][i];
  }
  return positive;
}

bool factoriseSquareOf(int columns, double* square, int stride, double* inverse_diagonal) {
  if constexpr (kColumns == 9) {
    if (columns == 9) return factoriseSquare<9>(square, stride, inverse_diagonal);
    if (columns == 6) return factoriseSquare<6>(square, stride, inverse_diagonal);
  }
  return factoriseSquare<3>(square, stride, inverse_diagonal);
}

/// Rows [first, end) of `columns` columns of a panel, from column c on: what the columns before c take from them, and
/// `solved`: the triangle of c itself.
void finishRows(double* panel, int stride, int c, int columns, int first, int end, bool solved,
                const double* inverse_diagonal) {
  for (int r = first; r < end; r += kRows) {
    const int rows = smaller(kRows, end - r);
    const int vectors = (rows + kWidth - 1) / kWidth;
    withTile(vectors, columns, [&](auto tile) SINEW_INLINE_CALL {
      const ColumnTriples there(panel + r + c * stride, stride);
      const RowVectors all = {kSequence, rows - (vectors - 1) * kWidth};
      tile.takeFrom(there, all, panel + r, stride, panel + c, stride, c);
      if (solved) tile.solve(panel + c + c * stride, stride, inverse_diagonal + c);
      tile.store(there, all);
    });
  }
}

bool factorise(double* panel, int stride, int columns, int rows, double* inverse_diagonal) {
  for (int c = 0; c < columns; c += kColumns) {
    const int count = smaller(kColumns, columns - c);
    if (c > 0) finishRows(panel, stride, c, count, c, c + count, false, inverse_diagonal);
    if (!factoriseSquareOf(count, panel + c + c * stride, stride, inverse_diagonal + c)) return false;
    finishRows(panel, stride, c, count, c + count, rows, true, inverse_diagonal);
  }
  return true;
}

/// Offsets of the vectors in the active groups of rows; returns how many.
int listVectors(std::uint64_t active, int group, int* offset) {
  int count = 0;
  for (int bit = 0; active != 0; ++bit, active >>= 1U) {
    if ((active & 1U) == 0) continue;
    for (int row = bit * group; row < (bit + 1) * group; row += kWidth) offset[count++] = row;
  }
  return count;
}

void forward(const double* panel, int stride, int columns, const double* inverse_diagonal, const int* below,
             int below_nodes, double* half, int half_stride, int first_column, std::uint64_t active, int group) {
  int offset[kMaxRowVectors];
  const int count = listVectors(active, group, offset);
  double* own = half + first_column * static_cast<long>(half_stride);
  for (int c = 0; c < columns; c += kColumns) {
    const int taken = smaller(kColumns, columns - c);
    const ColumnTriples there(own + c * half_stride, half_stride);
    for (int v = 0; v < count; v += kVectors) {
      withTile(smaller(kVectors, count - v), taken, [&](auto tile) SINEW_INLINE_CALL {
        const RowVectors rows = {offset + v, kWidth};
        tile.takeFrom(there, rows, own, half_stride, panel + c, stride, c);
        tile.solve(panel + c + c * stride, stride, inverse_diagonal + c);
        tile.store(there, rows);
      });
    }
  }
  for (int n = 0; n < below_nodes; n += kColumns / 3) {
    const int taken = smaller(kColumns / 3, below_nodes - n);
    ColumnTriples there(half_stride);
    for (int i = 0; i < taken; ++i) there.first[i] = half + 3 * below[n + i] * static_cast<long>(half_stride);
    for (int v = 0; v < count; v += kVectors) {
      withTile(smaller(kVectors, count - v), 3 * taken, [&](auto tile) SINEW_INLINE_CALL {
        const RowVectors rows = {offset + v, kWidth};
        tile.takeFrom(there, rows, own, half_stride, panel + columns + 3 * n, stride, columns);
        tile.store(there, rows);
      });
    }
  }
}

void product(const double* half, int half_stride, int depth, std::uint64_t active, int group, double* gram,
             int gram_stride) {
  int offset[kMaxRowVectors];
  const int count = listVectors(active, group, offset);
  const int end = count == 0 ? 0 : offset[count - 1] + kWidth;
  int first = 0;  // vector that reaches the diagonal
  for (int c = 0; c < end; c += kColumns) {
    const std::uint64_t bits = active >> static_cast<unsigned>(c / group);
    const bool second = (c + kColumns - 1) / group > c / group;
    if ((bits & (second ? 3U : 1U)) == 0) continue;
    while (offset[first] + kWidth <= c) ++first;
    const ColumnTriples there(gram + c * gram_stride, gram_stride);
    for (int v = first; v < count; v += kVectors) {
      withTile(smaller(kVectors, count - v), kColumns, [&](auto tile) SINEW_INLINE_CALL {
        const RowVectors rows = {offset + v, kWidth};
        tile.takeFrom(there, rows, half, half_stride, half + c, half_stride, depth);
        tile.store(there, rows);
      });
    }
  }
}

void combine(const double* half, int half_stride, std::uint64_t active, int group, const double* factor, int columns,
             double* result) {
  int offset[kMaxRowVectors];
  const int count = listVectors(active, group, offset);
  for (int j = 0; j < columns; j += 3, half += 3 * half_stride) {
    Simd total[3] = {Simd::fill(0), Simd::fill(0), Simd::fill(0)};
    for (int v = 0; v < count; ++v) {
      const Simd rows = Simd::load(factor + offset[v]);
      SINEW_UNROLL for (int d = 0; d < 3; ++d) {
        total[d] = multiplyAdd(Simd::load(half + d * half_stride + offset[v]), rows, total[d]);
      }
    }
    for (int d = 0; d < 3; ++d) result[j + d] = sum(total[d]);
  }
}

void backward(const double* panel, int stride, int columns, const double* inverse_diagonal, const int* below,
              int below_nodes, double* x, int first_column, double* gathered) {
  double* own = x + first_column;
  for (int i = 0; i < below_nodes; ++i) {
    for (int d = 0; d < 3; ++d) gathered[3 * i + d] = x[3 * below[i] + d];
  }
  for (int i = 0; i < kWidth; ++i) gathered[3 * below_nodes + i] = 0;
  for (int c = 0; c < columns; c += 3) {
    const double* column = panel + columns + c * stride;
    Simd total[3] = {Simd::fill(0), Simd::fill(0), Simd::fill(0)};
    for (int i = 0; i < 3 * below_nodes; i += kWidth) {
      const Simd rows = Simd::load(gathered + i);
      SINEW_UNROLL for (int d = 0; d < 3; ++d) {
        total[d] = multiplyAdd(rows, Simd::load(column + i + d * stride), total[d]);
      }
    }
    for (int d = 0; d < 3; ++d) own[c + d] -= sum(total[d]);
  }
  for (int c = columns - 1; c >= 0; --c) {
    own[c] *= inverse_diagonal[c];
    // Row c of the triangle, a stride apart, takes x_c from those before it.
    for (int j = 0; j < c; ++j) own[j] -= panel[c + j * stride] * own[c];
  }
}

}  // namespace

const SupernodalKernels& supernodalKernels() {
  static const SupernodalKernels kernels = {update, factorise, forward, product, combine, backward};
  return kernels;
}

}  // namespace SINEW_ISA
}  // namespace sinew
