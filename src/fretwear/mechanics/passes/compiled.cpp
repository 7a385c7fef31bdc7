// Passes over the cells of a window, compiled: see in_numpy.py for what each of them computes.
//
// Every pass is a loop that the compiler turns into vector instructions, on x86-64 with glibc in
// one version for each generation of processors, chosen when the library is loaded. Sums are taken
// over blocks of cells and the blocks added in double precision. Bounds are written so that what is
// not a number stays so.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 && defined(__x86_64__) && \
    defined(__GLIBC__)
#define VECTORIZED __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define VECTORIZED
#endif

#if defined(__GNUC__)
#define RESTRICT __restrict__
#define INLINED inline __attribute__((always_inline))
#else
#define RESTRICT
#define INLINED inline
#endif

namespace py = pybind11;

using Index = py::ssize_t;
constexpr Index BLOCK = 1024;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

// What a pass is given: a contiguous field of one type. One to be written is taken as it is or not at
// all, one that is only read is copied where it must be.
template <class T>
struct Field {
    T *data = nullptr;
    Index rows = 0, columns = 0;
    py::object kept;
    Index size() const { return rows * columns; }
};

namespace pybind11::detail {
template <class T>
struct type_caster<Field<T>> {
    PYBIND11_TYPE_CASTER(Field<T>, const_name("field"));
    bool load(handle source, bool convert) {
        using Taken = array_t<std::remove_const_t<T>, array::c_style>;
        const bool fits = Taken::check_(source), read_only = std::is_const_v<T>;
        if (!fits && !(read_only && convert)) return false;
        const auto field = fits ? reinterpret_borrow<Taken>(source) : Taken::ensure(source);
        if (!field || field.ndim() != 2 || !(read_only || field.writeable())) return false;
        value.data = const_cast<T *>(static_cast<const T *>(field.data()));
        value.rows = field.shape(0);
        value.columns = field.shape(1);
        value.kept = field;
        return true;
    }
};
}  // namespace pybind11::detail

using In32 = Field<const float>;
using In64 = Field<const double>;
using Out32 = Field<float>;
using Out64 = Field<double>;

static Index common_size(std::initializer_list<Index> sizes) {
    for (Index size : sizes)
        if (size != *sizes.begin()) throw std::invalid_argument("fields must be of one shape");
    return *sizes.begin();
}

template <class T>
static const T *data_or_null(const std::optional<Field<const T>> &field) {
    return field ? field->data : nullptr;
}

template <class T>
static Index size_or(const std::optional<Field<const T>> &field, Index otherwise) {
    return field ? field->size() : otherwise;
}

// Conjugate gradients.

template <class T>
INLINED static double inner_product(Index n, const T *RESTRICT a, const T *RESTRICT b) {
    double result = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        T sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index i = first; i < end; i++) sum += a[i] * b[i];
        result += sum;
    }
    return result;
}

VECTORIZED static double inner32(Index n, const float *a, const float *b) {
    return inner_product(n, a, b);
}

VECTORIZED static double inner64(Index n, const double *a, const double *b) {
    return inner_product(n, a, b);
}

VECTORIZED static double total(Index n, const float *field) {
    double result = 0;
#pragma omp simd reduction(+ : result)
    for (Index i = 0; i < n; i++) result += field[i];
    return result;
}

VECTORIZED static void relative(Index n, const double *RESTRICT field, double unit,
                                const float *RESTRICT inside, float *RESTRICT result) {
    const double per_unit = 1.0 / unit;
#pragma omp simd
    for (Index i = 0; i < n; i++) result[i] = static_cast<float>(field[i] * per_unit) * inside[i];
}

VECTORIZED static double scaled(Index n, const double *RESTRICT field, float *RESTRICT result) {
    double largest = 0;
#pragma omp simd reduction(max : largest)
    for (Index i = 0; i < n; i++)
        largest = std::fabs(field[i]) > largest ? std::fabs(field[i]) : largest;
    if (largest < std::numeric_limits<double>::min()) largest = 1;
    const double per_unit = 1.0 / largest;
#pragma omp simd
    for (Index i = 0; i < n; i++) result[i] = static_cast<float>(field[i] * per_unit);
    return largest;
}

VECTORIZED static double lower(Index n, float shift, const float *RESTRICT inside,
                               float *RESTRICT residual) {
    double result = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        float sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index i = first; i < end; i++) {
            const float value = residual[i] - shift;
            residual[i] = value;
            sum += value * value * inside[i];
        }
        result += sum;
    }
    return result;
}

VECTORIZED static void shares(Index n, const float *RESTRICT tangent, float turn, float factor,
                              float mean, float *RESTRICT soft, float *RESTRICT hard) {
#pragma omp simd
    for (Index i = 0; i < n; i++) {
        float share = tangent[i] / (tangent[i] + turn) * factor;
        share = share > 1 ? 1 : share;
        const float above = (mean + 1) / (tangent[i] + 1);
        hard[i] = std::sqrt(1 - share);
        soft[i] = std::sqrt(share * (above > 1 ? 1 : above));
    }
}

// Some cells of one row; the inner product with the residual.
VECTORIZED static float weigh(Index n, const float *RESTRICT weight, const float *RESTRICT residual,
                              float *RESTRICT field) {
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (Index i = 0; i < n; i++) {
        const float value = field[i] * weight[i];
        field[i] = value;
        sum += value * residual[i];
    }
    return sum;
}

VECTORIZED static float weigh_both(Index n, const float *RESTRICT weight,
                                   const float *RESTRICT inner_weight, const float *RESTRICT inner,
                                   const float *RESTRICT residual, float *RESTRICT field) {
    float sum = 0;
#pragma omp simd reduction(+ : sum)
    for (Index i = 0; i < n; i++) {
        const float value = field[i] * weight[i] + inner[i] * inner_weight[i];
        field[i] = value;
        sum += value * residual[i];
    }
    return sum;
}

static py::array_t<float> weighed(In32 weight, std::pair<Index, Index> corner, In32 field) {
    const auto [x, y] = corner;
    if (x < 0 || y < 0 || x + weight.rows > field.rows || y + weight.columns > field.columns)
        throw std::invalid_argument("the weight must lie within the field");
    py::array_t<float> result({weight.rows, weight.columns});
    float *RESTRICT to = result.mutable_data();
    for (Index row = 0; row < weight.rows; row++) {
        const float *RESTRICT w = weight.data + row * weight.columns;
        const float *RESTRICT f = field.data + (row + x) * field.columns + y;
        float *RESTRICT part = to + row * weight.columns;
#pragma omp simd
        for (Index i = 0; i < weight.columns; i++) part[i] = w[i] * f[i];
    }
    return result;
}

static double blend(In32 weight, const std::optional<In32> &inner_weight,
                    const std::optional<In32> &inner, std::pair<Index, Index> corner,
                    In32 residual, Out32 field) {
    const Index columns = field.columns;
    common_size({weight.size(), residual.size(), field.size()});
    const auto [x, y] = corner;
    Index nx = 0, ny = 0;
    if (inner && inner_weight) {
        common_size({inner->size(), inner_weight->size()});
        nx = inner->rows, ny = inner->columns;
        if (x < 0 || y < 0 || x + nx > field.rows || y + ny > columns)
            throw std::invalid_argument("the inner field must lie within the other");
    }
    double result = 0;
    for (Index row = 0; row < field.rows; row++) {
        const Index start = row * columns;
        const float *w = weight.data + start, *r = residual.data + start;
        float *f = field.data + start;
        if (row < x || row >= x + nx) {
            result += weigh(columns, w, r, f);
            continue;
        }
        const Index inside = (row - x) * ny, end = y + ny;
        result += weigh(y, w, r, f);
        result += weigh_both(ny, w + y, inner_weight->data + inside, inner->data + inside, r + y,
                             f + y);
        result += weigh(columns - end, w + end, r + end, f + end);
    }
    return result;
}

VECTORIZED static void turn(Index n, float factor, const float *RESTRICT field,
                            float *RESTRICT direction) {
#pragma omp simd
    for (Index i = 0; i < n; i++) direction[i] = factor * direction[i] + field[i];
}

VECTORIZED static double respond(Index n, const float *RESTRICT tangent,
                                 const float *RESTRICT direction, float *RESTRICT force) {
    double result = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        float sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index i = first; i < end; i++) {
            const float value = force[i] + tangent[i] * direction[i];
            force[i] = value;
            sum += value * direction[i];
        }
        result += sum;
    }
    return result;
}

VECTORIZED static double follow(Index n, float length, const float *RESTRICT direction,
                                const float *RESTRICT force, const float *RESTRICT weight,
                                float *RESTRICT pressure, float *RESTRICT residual) {
    double result = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        float sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index i = first; i < end; i++) {
            pressure[i] += length * direction[i];
            const float value = residual[i] - length * force[i];
            residual[i] = value;
            sum += value * weight[i];
        }
        result += sum;
    }
    return result;
}

VECTORIZED static float settle(Index n, const float *RESTRICT start, const float *RESTRICT tangent,
                               const float *RESTRICT pressure, float shift,
                               float *RESTRICT residual) {
    float largest = 0;
    if (tangent) {
#pragma omp simd reduction(max : largest)
        for (Index i = 0; i < n; i++) {
            const float value = start[i] - residual[i] - shift - tangent[i] * pressure[i];
            residual[i] = value;
            largest = std::fabs(value) > largest ? std::fabs(value) : largest;
        }
    } else {
#pragma omp simd reduction(max : largest)
        for (Index i = 0; i < n; i++) {
            const float value = start[i] - residual[i] - shift;
            residual[i] = value;
            largest = std::fabs(value) > largest ? std::fabs(value) : largest;
        }
    }
    return largest;
}

// The active set.

VECTORIZED static void judge(Index n, const double *RESTRICT separation,
                             const double *RESTRICT displacement, const double *RESTRICT pressure,
                             double limit, double *RESTRICT gap, double *RESTRICT result) {
    double free_sum = 0, free_count = 0, highest = -INFINITE;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0, count = 0;
#pragma omp simd reduction(+ : sum, count) reduction(max : highest)
        for (Index i = first; i < end; i++) {
            const double free = (pressure[i] > 0) & (pressure[i] < limit) ? 1.0 : 0.0;
            sum += free * separation[i];
            count += free;
            highest = displacement[i] > highest ? displacement[i] : highest;
        }
        free_sum += sum;
        free_count += count;
    }
    double approach = -INFINITE;
    if (free_count > 0) {
        approach = free_sum / free_count;
    } else {
        for (Index i = 0; i < n; i++)
            if (pressure[i] >= limit && separation[i] > approach) approach = separation[i];
    }
    double worst = 0, all = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0;
#pragma omp simd reduction(+ : sum) reduction(max : worst)
        for (Index i = first; i < end; i++) {
            const double value = separation[i] - approach;
            gap[i] = value;
            sum += value;
            double violation = pressure[i] >= limit ? value : std::fabs(value);
            violation = pressure[i] > 0 ? violation : -value;
            worst = violation > worst ? violation : worst;
        }
        all += sum;
    }
    result[0] = approach, result[1] = worst, result[2] = highest, result[3] = all;
}

VECTORIZED static void to_free(Index n, const double *RESTRICT pressure, double limit,
                               const double *RESTRICT gap, double slack,
                               std::uint8_t *RESTRICT result) {
#pragma omp simd
    for (Index i = 0; i < n; i++) {
        const std::uint8_t open = pressure[i] <= 0, saturated = pressure[i] >= limit;
        const std::uint8_t closes = gap[i] < -slack, parts = gap[i] > slack;
        result[i] = (open & closes) | (saturated & parts) | ((open | saturated) ^ 1);
    }
}

VECTORIZED static void propose(Index n, const double *RESTRICT pressure, const double *RESTRICT gap,
                               const float *RESTRICT found, double unit,
                               const float *RESTRICT uniform, double share, double *RESTRICT step,
                               double *RESTRICT result) {
    double lowest = INFINITE, highest = -INFINITE, along = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0;
#pragma omp simd reduction(+ : sum) reduction(min : lowest) reduction(max : highest)
        for (Index i = first; i < end; i++) {
            const double value = found[i] * unit - uniform[i] * share;
            step[i] = value;
            const double target = pressure[i] + value;
            lowest = target < lowest ? target : lowest;
            highest = target > highest ? target : highest;
            sum += value * gap[i];
        }
        along += sum;
    }
    result[0] = lowest, result[1] = highest, result[2] = along;
}

VECTORIZED static void descent(Index n, const double *RESTRICT gap, const double *RESTRICT step,
                               double *RESTRICT result) {
    result[0] = result[1] = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0, magnitudes = 0;
#pragma omp simd reduction(+ : sum, magnitudes)
        for (Index i = first; i < end; i++) {
            const double product = gap[i] * step[i];
            sum += product;
            magnitudes += std::fabs(product);
        }
        result[0] += sum;
        result[1] += magnitudes;
    }
}

VECTORIZED static void move(Index n, double fraction, const double *RESTRICT step, double limit,
                            const float *RESTRICT moved, double unit, double offset,
                            const double *RESTRICT shape, double *RESTRICT pressure,
                            double *RESTRICT displacement, double *RESTRICT separation) {
    const double part = fraction * unit, shift = fraction * offset;
#pragma omp simd
    for (Index i = 0; i < n; i++) {
        double target = pressure[i] + fraction * step[i];
        target = target < 0 ? 0 : target;
        pressure[i] = target > limit ? limit : target;
        const double value = displacement[i] + part * moved[i] + shift;
        displacement[i] = value;
        separation[i] = value + shape[i];
    }
}

VECTORIZED static void scale_and_sum(Index n, double factor, double limit, double rigid,
                                     double *RESTRICT pressure, double *RESTRICT result) {
    // Cells from `rigid` on keep their pressure.
    double carried = 0, saturated = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0, count = 0;
#pragma omp simd reduction(+ : sum, count)
        for (Index i = first; i < end; i++) {
            const double before = pressure[i];
            double value = before * factor;
            value = value < 0 ? 0 : value;
            value = value > limit ? limit : value;
            value = before >= rigid ? before : value;
            pressure[i] = value;
            sum += value;
            count += value >= limit ? 1.0 : 0.0;
        }
        carried += sum;
        saturated += count;
    }
    result[0] = carried, result[1] = saturated;
}

static void carrying(Index n, double limit, double total, double *pressure) {
    constexpr int LARGEST_SCALINGS = 100;
    constexpr double NOTHING = 1e-12;
    double result[2];
    scale_and_sum(n, 1.0, limit, INFINITE, pressure, result);
    for (int scalings = 0; scalings < LARGEST_SCALINGS; scalings++) {
        const auto [carried, saturated] = result;
        const double missing = total - carried;
        if (std::fabs(missing) <= 1e-14 * total) break;
        const double movable = saturated > 0 ? carried - limit * saturated : carried;
        if (movable <= -missing) {
            scale_and_sum(n, total / carried, limit, INFINITE, pressure, result);
        } else if (movable <= NOTHING * carried) {
            for (Index i = 0; i < n; i++) pressure[i] = std::max(pressure[i], 1e-3 * limit);
            scale_and_sum(n, 1.0, limit, INFINITE, pressure, result);
        } else {
            scale_and_sum(n, 1.0 + missing / movable, limit, limit, pressure, result);
        }
    }
}

// The wear of a stage.

constexpr double LARGEST_EXPONENT = 200.0;
constexpr double LARGEST_SLOPE = 1e30;
constexpr double TINY = 1e-12;
constexpr double SMALL = 3e-5;

// eˣ − 1 as 2ᵏ (eʳ − 1) + (2ᵏ − 1) with x = k ln 2 + r and the Taylor series of eʳ − 1, |r| < 0.35:
// good to two units in the last place, for x up to 700 in magnitude.
INLINED static double expm1_of(double x) {
    constexpr double ROUNDING = 6755399441055744.0;  // 1.5 · 2⁵²: adding it rounds to an integer
    constexpr double LN2_HIGH = 6.93147180369123816490e-01, LN2_LOW = 1.90821492927058770002e-10;
    const double rounded = x * 1.4426950408889634 + ROUNDING;
    const double k = rounded - ROUNDING;
    std::uint64_t bits;
    std::memcpy(&bits, &rounded, sizeof bits);
    bits = (bits + 1023) << 52;
    double power;
    std::memcpy(&power, &bits, sizeof power);
    const double r = (x - k * LN2_HIGH) - k * LN2_LOW;
    double series = 1.0 / 6227020800.0;
    series = series * r + 1.0 / 479001600.0;
    series = series * r + 1.0 / 39916800.0;
    series = series * r + 1.0 / 3628800.0;
    series = series * r + 1.0 / 362880.0;
    series = series * r + 1.0 / 40320.0;
    series = series * r + 1.0 / 5040.0;
    series = series * r + 1.0 / 720.0;
    series = series * r + 1.0 / 120.0;
    series = series * r + 1.0 / 24.0;
    series = series * r + 1.0 / 6.0;
    series = series * r + 0.5;
    series = series * r * r + r;
    return power * series + (power - 1.0);
}

INLINED static double exponent_of(double pressure, double rate, double known) {
    const double x = rate * pressure + known;
    return x > LARGEST_EXPONENT ? LARGEST_EXPONENT : x;
}

VECTORIZED static void wear(Index n, const double *RESTRICT pressure, double rate,
                            const double *RESTRICT known, const double *RESTRICT start,
                            const double *RESTRICT reduced_gap, const double *RESTRICT shift,
                            double *RESTRICT result) {
    if (shift) {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            const double growth = expm1_of(x), divisor = x < TINY ? TINY : x;
            const double worn = growth * reduced_gap[i] + (growth - x) / divisor * shift[i];
            result[i] += (worn < 0 ? 0 : worn) + start[i];
        }
    } else {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            result[i] += expm1_of(x) * reduced_gap[i] + start[i];
        }
    }
}

template <class T>
INLINED static void slope_of_wear(Index n, const double *RESTRICT pressure, double rate,
                                  const double *RESTRICT known,
                                  const double *RESTRICT reduced_gap,
                                  const double *RESTRICT shift, double factor,
                                  T *RESTRICT result) {
    if (shift) {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            const double above = x < SMALL ? SMALL : x, growth = expm1_of(above);
            const double per_above = 1.0 / above;
            const double phi_slope = ((above - growth) * per_above + growth) * per_above;
            const double below = x < SMALL ? (x - SMALL) / 3.0 : 0.0;
            double slope = (growth + 1.0) * reduced_gap[i] + (phi_slope + below) * shift[i];
            slope = slope < 0 ? 0 : slope * factor;
            result[i] = static_cast<T>(slope > LARGEST_SLOPE ? LARGEST_SLOPE : slope);
        }
    } else {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            const double slope = (expm1_of(x) + 1.0) * reduced_gap[i] * factor;
            result[i] = static_cast<T>(slope > LARGEST_SLOPE ? LARGEST_SLOPE : slope);
        }
    }
}

VECTORIZED static void slope32(Index n, const double *pressure, double rate, const double *known,
                               const double *reduced_gap, const double *shift, double factor,
                               float *result) {
    slope_of_wear(n, pressure, rate, known, reduced_gap, shift, factor, result);
}

VECTORIZED static void slope64(Index n, const double *pressure, double rate, const double *known,
                               const double *reduced_gap, const double *shift, double factor,
                               double *result) {
    slope_of_wear(n, pressure, rate, known, reduced_gap, shift, factor, result);
}

// Python's side: sizes are compared, fields taken apart.

PYBIND11_MODULE(compiled, module) {
    module.doc() = "The passes of in_numpy.py, compiled.";
    module.def("inner", [](In32 a, In32 b) {
        return inner32(common_size({a.size(), b.size()}), a.data, b.data);
    });
    module.def("inner", [](In64 a, In64 b) {
        return inner64(common_size({a.size(), b.size()}), a.data, b.data);
    });
    module.def("total", [](In32 field) { return total(field.size(), field.data); });
    module.def("relative", [](In64 field, double unit, In32 inside) {
        const Index n = common_size({field.size(), inside.size()});
        py::array_t<float> result({inside.rows, inside.columns});
        relative(n, field.data, unit, inside.data, result.mutable_data());
        return result;
    });
    module.def("scaled", [](In64 field) {
        py::array_t<float> result({field.rows, field.columns});
        const double unit = scaled(field.size(), field.data, result.mutable_data());
        return std::make_tuple(result, unit);
    });
    module.def("lower", [](float shift, In32 inside, Out32 residual) {
        const Index n = common_size({inside.size(), residual.size()});
        return lower(n, shift, inside.data, residual.data);
    });
    module.def("weighed", &weighed);
    module.def("shares", [](In32 tangent, double mean, double turn) {
        py::array_t<float> soft({tangent.rows, tangent.columns});
        py::array_t<float> hard({tangent.rows, tangent.columns});
        shares(tangent.size(), tangent.data, static_cast<float>(turn),
               static_cast<float>((mean + turn) / mean), static_cast<float>(mean),
               soft.mutable_data(), hard.mutable_data());
        return std::make_tuple(soft, hard);
    });
    module.def("blend", &blend);
    module.def("turn", [](float factor, In32 field, Out32 direction) {
        turn(common_size({field.size(), direction.size()}), factor, field.data, direction.data);
    });
    module.def("respond", [](const std::optional<In32> &tangent, In32 direction, Out32 force) {
        const Index n = common_size({direction.size(), force.size(), size_or(tangent, force.size())});
        if (!tangent) return inner32(n, direction.data, force.data);
        return respond(n, tangent->data, direction.data, force.data);
    });
    module.def("follow", [](float length, In32 direction, In32 force, In32 weight, Out32 pressure,
                            Out32 residual) {
        const Index n = common_size({direction.size(), force.size(), weight.size(),
                                     pressure.size(), residual.size()});
        return follow(n, length, direction.data, force.data, weight.data, pressure.data,
                      residual.data);
    });
    module.def("settle", [](In32 start, const std::optional<In32> &tangent, In32 pressure,
                            float shift, Out32 residual) {
        const Index n = common_size({start.size(), size_or(tangent, start.size()),
                                     pressure.size(), residual.size()});
        return settle(n, start.data, data_or_null(tangent), pressure.data, shift, residual.data);
    });
    module.def("judge", [](In64 separation, In64 displacement, In64 pressure, double limit,
                           Out64 gap) {
        const Index n = common_size({separation.size(), displacement.size(), pressure.size(),
                                     gap.size()});
        double result[4];
        judge(n, separation.data, displacement.data, pressure.data, limit, gap.data, result);
        return std::make_tuple(result[0], result[1], result[2], result[3]);
    });
    module.def("to_free", [](In64 pressure, double limit, In64 gap, double slack) {
        const Index n = common_size({pressure.size(), gap.size()});
        py::array_t<bool> result({pressure.rows, pressure.columns});
        to_free(n, pressure.data, limit, gap.data, slack,
                reinterpret_cast<std::uint8_t *>(result.mutable_data()));
        return result;
    });
    module.def("propose", [](In64 pressure, In64 gap, In32 found, double unit, In32 uniform,
                             double share, Out64 step) {
        const Index n = common_size({pressure.size(), gap.size(), found.size(), uniform.size(),
                                     step.size()});
        double result[3];
        propose(n, pressure.data, gap.data, found.data, unit, uniform.data, share, step.data,
                result);
        return std::make_tuple(result[0], result[1], result[2]);
    });
    module.def("descent", [](In64 gap, In64 step) {
        double result[2];
        descent(common_size({gap.size(), step.size()}), gap.data, step.data, result);
        return std::make_tuple(result[0], result[1]);
    });
    module.def("move", [](double fraction, In64 step, double limit, In32 moved, double unit,
                          double offset, In64 shape, Out64 pressure, Out64 displacement,
                          Out64 separation) {
        const Index n = common_size({step.size(), moved.size(), shape.size(), pressure.size(),
                                     displacement.size(), separation.size()});
        move(n, fraction, step.data, limit, moved.data, unit, offset, shape.data, pressure.data,
             displacement.data, separation.data);
    });
    module.def("carrying", [](In64 pressure, double limit, double total) {
        py::array_t<double> result({pressure.rows, pressure.columns});
        std::copy(pressure.data, pressure.data + pressure.size(), result.mutable_data());
        carrying(pressure.size(), limit, total, result.mutable_data());
        return result;
    });
    module.def("wear", [](In64 pressure, double rate, In64 known, In64 start, In64 reduced_gap,
                          const std::optional<In64> &shift, Out64 result) {
        const Index n = common_size({pressure.size(), known.size(), start.size(),
                                     reduced_gap.size(), size_or(shift, result.size()),
                                     result.size()});
        wear(n, pressure.data, rate, known.data, start.data, reduced_gap.data,
             data_or_null(shift), result.data);
    });
    const auto slope = [&module](auto into, auto pass) {
        using Out = decltype(into);
        module.def("wear_slope", [pass](In64 pressure, double rate, In64 known, In64 reduced_gap,
                                        const std::optional<In64> &shift, double factor,
                                        Out result) {
            const Index n = common_size({pressure.size(), known.size(), reduced_gap.size(),
                                         size_or(shift, result.size()), result.size()});
            pass(n, pressure.data, rate, known.data, reduced_gap.data, data_or_null(shift),
                 factor, result.data);
        });
    };
    slope(Out32{}, &slope32);
    slope(Out64{}, &slope64);
}
