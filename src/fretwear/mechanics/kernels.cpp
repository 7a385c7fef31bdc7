// Arithmetic on the cells between two transforms, compiled: see kernels.py for what each function is.
//
// Every kernel is a loop that the compiler turns into vector instructions, on x86-64 with glibc in
// one version for each generation of processors, chosen when the library is loaded. Sums are taken
// over blocks of cells and the blocks added in double precision. Bounds are written so that what is
// not a number stays so.

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <complex>
#include <condition_variable>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12 && defined(__x86_64__) && \
    defined(__GLIBC__)
#define VECTORIZED __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define TRANSFORMS
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
// Fields of so few cells are not shared; others are, in so many parts of whole blocks.
constexpr Index UNSHARED = 1 << 17, PARTS = 16;
constexpr double INFINITE = std::numeric_limits<double>::infinity();

// What a kernel is given: a contiguous field of one type. One to be written is taken as it is or not at
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

// How the arguments of a kernel come from Python: what points to cells is a field, all of one size;
// what may point to none is a field or None.
template <class T>
struct Maybe {
    const T *data;
};
template <class P>
struct Argument {
    using Given = P;
    static P passed(const P &given, Index) { return given; }
    static Index size(const P &, Index n) { return n; }
};
template <class T>
struct Argument<T *> {
    using Given = Field<T>;
    static T *passed(const Given &given, Index first) { return given.data + first; }
    static Index size(const Given &given, Index) { return given.size(); }
};
template <class T>
struct Argument<Maybe<T>> {
    using Given = std::optional<Field<const T>>;
    static Maybe<T> passed(const Given &given, Index first) {
        return {given ? given->data + first : nullptr};
    }
    static Index size(const Given &given, Index n) { return given ? given->size() : n; }
};

// Threads that share the parts of a job, the caller's one of them. Passes over the cells follow each
// other within less time than it takes to wake a thread: one without work looks for some for a while
// before it sleeps.
class Threads {
  public:
    explicit Threads(int count) : count(count) {}

    ~Threads() {
        const py::gil_scoped_release while_they_end;
        ended = true;
        begin();
        for (auto &each : others) each.join();
    }

    // Call a function for each of so many parts.
    template <class F>
    void share(Index parts, F function) {
        std::atomic<Index> next{0};
        const auto work = [&] {
            for (Index part; (part = next++) < parts;) function(part);
        };
        parts < 2 ? work() : together(work);
    }

    // What a function of Python returns for each of some parts, in their order.
    py::list each(const py::function &function, const py::sequence &parts) {
        const auto number = static_cast<Index>(parts.size());
        std::atomic<Index> next{0};
        py::list results(number);
        const py::gil_scoped_release while_others_compute;
        together([&] {
            const py::gil_scoped_acquire interpreter;
            for (Index part; (part = next++) < number;)
                results[part] = function(py::object(parts[part]));
        });
        return results;
    }

  private:
    const int count;
    std::vector<std::thread> others;
    std::function<void()> job;
    std::exception_ptr error;
    std::atomic<bool> ended{false};
    std::atomic<unsigned> round{0};
    std::atomic<int> busy{0};
    std::mutex mutex;
    std::condition_variable changed;

    // Let every thread work; what one throws is thrown here.
    template <class F>
    void together(F work) {
        while (static_cast<int>(others.size()) < count - 1) others.emplace_back([this] { serve(); });
        job = work;
        busy = count - 1;
        begin();
        guarded();
        await([this] { return busy == 0; });
        if (error) std::rethrow_exception(std::exchange(error, nullptr));
    }

    void begin() {
        {
            const std::lock_guard<std::mutex> lock(mutex);
            round++;
        }
        changed.notify_all();
    }

    void guarded() {
        try {
            job();
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex);
            error = std::current_exception();
        }
    }

    void serve() {
        for (unsigned seen = 0;;) {
            await([&] { return round != seen; });
            seen = round;
            if (ended) return;
            guarded();
            if (--busy > 0) continue;
            { const std::lock_guard<std::mutex> lock(mutex); }
            changed.notify_all();
        }
    }

    template <class F>
    void await(F holds) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(500);
        do {
            for (int look = 0; look < 100; look++)
                if (holds()) return;
        } while (std::chrono::steady_clock::now() < end);
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait(lock, holds);
    }
};

static void require(bool holds, const char *message) {
    if (!holds) throw std::invalid_argument(message);
}

// A kernel of fields goes over them in parts, the same for however many threads: results by part.
template <class R, class... P>
static void bind(py::module_ &module, const char *name, R (*kernel)(Index, P...)) {
    module.def(name, [kernel](Threads &threads, const typename Argument<P>::Given &...given) {
        const Index n = std::max({Argument<P>::size(given, 0)...});
        require(((Argument<P>::size(given, n) == n) && ...), "fields must be of one shape");
        const Index share = n <= UNSHARED ? n : ((n - 1) / (PARTS * BLOCK) + 1) * BLOCK;
        using Result = std::conditional_t<std::is_void_v<R>, bool, R>;
        std::vector<Result> results(std::is_void_v<R> ? 0 : (n + share - 1) / share);
        const py::gil_scoped_release while_others_compute;
        threads.share((n + share - 1) / share, [&](Index part) {
            const Index first = part * share, cells = std::min(share, n - first);
            if constexpr (std::is_void_v<R>)
                kernel(cells, Argument<P>::passed(given, first)...);
            else
                results[part] = kernel(cells, Argument<P>::passed(given, first)...);
        });
        return results;
    });
}

// The product of two matrices, row by row, each in pieces that stay in the cache's first level.
VECTORIZED static void multiply_matrices(Index rows, Index between, Index columns, const double *left,
                                         const double *right, double *result) {
    constexpr Index WIDTH = 64;
    for (Index i = 0; i < rows; i++)
        for (Index first = 0; first < columns; first += WIDTH) {
            const Index width = std::min(WIDTH, columns - first);
            double sums[WIDTH] = {};
            for (Index k = 0; k < between; k++) {
                const double factor = left[i * between + k];
                const double *RESTRICT row = right + k * columns + first;
#pragma omp simd
                for (Index j = 0; j < width; j++) sums[j] += factor * row[j];
            }
            std::copy_n(sums, width, result + i * columns + first);
        }
}

static py::array_t<double> product(const Field<const double> &left,
                                   const Field<const double> &right) {
    require(left.columns == right.rows, "matrices must fit");
    py::array_t<double> result({left.rows, right.columns});
    double *data = result.mutable_data();
    const py::gil_scoped_release while_others_compute;
    multiply_matrices(left.rows, left.columns, right.columns, left.data, right.data, data);
    return result;
}

// Conjugate gradients.

// Sum over the cells of what a function gives for each: in the precision of T within a block.
template <class T, class F>
INLINED static double sum_of(Index n, F term) {
    double result = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        T sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index i = first; i < end; i++) sum += term(i);
        result += sum;
    }
    return result;
}

VECTORIZED static double inner32(Index n, const float *a, const float *b) {
    return sum_of<float>(n, [=](Index i) { return a[i] * b[i]; });
}

VECTORIZED static double inner64(Index n, const double *a, const double *b) {
    return sum_of<double>(n, [=](Index i) { return a[i] * b[i]; });
}

VECTORIZED static double total(Index n, const float *field) {
    double result = 0;
#pragma omp simd reduction(+ : result)
    for (Index i = 0; i < n; i++) result += field[i];
    return result;
}

template <class F>
INLINED static auto largest_of(Index n, F value) {
    std::decay_t<decltype(value(n))> largest = 0;
#pragma omp simd reduction(max : largest)
    for (Index i = 0; i < n; i++) {
        const auto magnitude = std::fabs(value(i));
        largest = magnitude > largest ? magnitude : largest;
    }
    return largest;
}

VECTORIZED static double largest32(Index n, const float *field) {
    return largest_of(n, [=](Index i) { return field[i]; });
}

VECTORIZED static double largest64(Index n, const double *field) {
    return largest_of(n, [=](Index i) { return field[i]; });
}

VECTORIZED static void times(Index n, const float *RESTRICT field, const float *RESTRICT factor,
                             float *result) {
#pragma omp simd
    for (Index i = 0; i < n; i++) result[i] = field[i] * factor[i];
}

VECTORIZED static void times_number(Index n, const double *RESTRICT field, double factor,
                                    float *RESTRICT result) {
#pragma omp simd
    for (Index i = 0; i < n; i++) result[i] = static_cast<float>(field[i] * factor);
}

VECTORIZED static double project_mean(Index n, float shift, const float *RESTRICT inside,
                                      float *RESTRICT residual) {
    return sum_of<float>(n, [=](Index i) {
        residual[i] -= shift;
        return residual[i] * residual[i] * inside[i];
    });
}

VECTORIZED static double weigh(Index n, const float *RESTRICT weight, const float *RESTRICT residual,
                               float *RESTRICT field) {
    return sum_of<float>(n, [=](Index i) { return (field[i] *= weight[i]) * residual[i]; });
}

VECTORIZED static void update_direction(Index n, float factor, const float *RESTRICT field,
                            float *RESTRICT direction) {
#pragma omp simd
    for (Index i = 0; i < n; i++) direction[i] = factor * direction[i] + field[i];
}

VECTORIZED static double add_layer(Index n, Maybe<float> tangent, const float *RESTRICT direction,
                                   float *RESTRICT force) {
    const float *RESTRICT layer = tangent.data;
    if (!layer) return sum_of<float>(n, [=](Index i) { return direction[i] * force[i]; });
    return sum_of<float>(n, [=](Index i) {
        force[i] += layer[i] * direction[i];
        return force[i] * direction[i];
    });
}

VECTORIZED static double advance(Index n, float length, const float *RESTRICT direction,
                                 const float *RESTRICT force, const float *RESTRICT weight,
                                 float *RESTRICT pressure, float *RESTRICT residual) {
    return sum_of<float>(n, [=](Index i) {
        pressure[i] += length * direction[i];
        residual[i] -= length * force[i];
        return residual[i] * weight[i];
    });
}

VECTORIZED static float recover_displacement(Index n, const float *RESTRICT start,
                                             Maybe<float> tangent, const float *RESTRICT pressure,
                                             float shift, float *RESTRICT residual) {
    const float *RESTRICT layer = tangent.data;
    if (!layer)
        return largest_of(n, [=](Index i) { return residual[i] = start[i] - residual[i] - shift; });
    return largest_of(n, [=](Index i) {
        return residual[i] = start[i] - residual[i] - shift - layer[i] * pressure[i];
    });
}

// The active set.

template <bool WEIGHTED>
INLINED static std::pair<double, double> scaled_and_clipped(Index n, double factor, double limit,
                                                            double rigid, const double *weight,
                                                            double *RESTRICT pressure) {
    double carried = 0, saturated = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0, count = 0;
#pragma omp simd reduction(+ : sum, count)
        for (Index i = first; i < end; i++) {
            const double before = pressure[i], unit = WEIGHTED ? weight[i] : 1.0;
            double value = before * factor;
            value = value < 0 ? 0 : value;
            value = value > limit ? limit : value;
            value = before >= rigid ? before : value;
            pressure[i] = value;
            sum += unit * value;
            count += value >= limit ? unit : 0.0;
        }
        carried += sum;
        saturated += count;
    }
    return {carried, saturated};
}

VECTORIZED static std::pair<double, double> scale_and_clip(Index n, double factor, double limit,
                                                           double rigid, Maybe<double> weights,
                                                           double *RESTRICT pressure) {
    return weights.data ? scaled_and_clipped<true>(n, factor, limit, rigid, weights.data, pressure)
                        : scaled_and_clipped<false>(n, factor, limit, rigid, nullptr, pressure);
}

VECTORIZED static std::tuple<double, double, double> level(
    Index n, double limit, const double *RESTRICT separation, const double *RESTRICT displacement,
    const double *RESTRICT pressure) {
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
    return {free_sum, free_count, highest};
}

VECTORIZED static std::pair<double, double> evaluate(
    Index n, const double *RESTRICT separation, const double *RESTRICT pressure, double limit,
    double approach, double slack, double *RESTRICT gap, bool *RESTRICT to_be_free) {
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
            const bool open = pressure[i] <= 0, saturated = pressure[i] >= limit;
            const bool closes = value < -slack, parts = value > slack;
            to_be_free[i] = (open & closes) | (saturated & parts) | !(open | saturated);
        }
        all += sum;
    }
    return {worst, all};
}

VECTORIZED static std::tuple<double, double, double> scale_step(
    Index n, const double *RESTRICT pressure, const double *RESTRICT gap,
    const float *RESTRICT found, double unit, const float *RESTRICT uniform, double share,
    double *RESTRICT step) {
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
    return {lowest, highest, along};
}

VECTORIZED static std::pair<double, double> descent(Index n, const double *RESTRICT gap,
                                                    const double *RESTRICT step) {
    double along = 0, magnitude = 0;
    for (Index first = 0; first < n; first += BLOCK) {
        const Index end = std::min(first + BLOCK, n);
        double sum = 0, magnitudes = 0;
#pragma omp simd reduction(+ : sum, magnitudes)
        for (Index i = first; i < end; i++) {
            const double product = gap[i] * step[i];
            sum += product;
            magnitudes += std::fabs(product);
        }
        along += sum;
        magnitude += magnitudes;
    }
    return {along, magnitude};
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
                            const double *RESTRICT reduced_gap, Maybe<double> flow,
                            double *RESTRICT result) {
    const double *RESTRICT shift = flow.data;
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

INLINED static void slope_of_wear(Index n, const double *RESTRICT pressure, double rate,
                                  const double *RESTRICT known,
                                  const double *RESTRICT reduced_gap,
                                  const double *RESTRICT shift, double factor,
                                  float *RESTRICT result) {
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
            result[i] = static_cast<float>(slope > LARGEST_SLOPE ? LARGEST_SLOPE : slope);
        }
    } else {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            const double slope = (expm1_of(x) + 1.0) * reduced_gap[i] * factor;
            result[i] = static_cast<float>(slope > LARGEST_SLOPE ? LARGEST_SLOPE : slope);
        }
    }
}

VECTORIZED static void wear_slope(Index n, const double *pressure, double rate, const double *known,
                                  const double *reduced_gap, Maybe<double> shift, double factor,
                                  float *result) {
    slope_of_wear(n, pressure, rate, known, reduced_gap, shift.data, factor, result);
}

// Convolution of a field on a window that is even along neither axis: see convolution.py.
//
// Several lines are transformed at a time, one in each lane of a vector. Spectra of the kernel are real
// and even: two columns are the real and the imaginary part of one line, and what belongs to a frequency
// along x is a line of complex numbers along y, whose parts lie in a row and in the one that mirrors it.
// Where processors have no vectors of this length, other transforms are faster.

#if defined(TRANSFORMS)

template <class T>
struct VectorOf {
    typedef T type __attribute__((vector_size(32)));
};
template <class T>
using Vector = typename VectorOf<T>::type;
template <class T>
constexpr Index LANES = 32 / sizeof(T);

// A complex number of each line.
template <class T>
struct Lines {
    alignas(32) Vector<T> re;
    alignas(32) Vector<T> im;

    INLINED Lines turned(T c, T s) const { return {re * c - im * s, im * c + re * s}; }
};

// The factors of a length that is a product of 2, 3 and 5, and what the transforms multiply by.
template <class T>
struct Plan {
    Index count;
    std::vector<Index> factors;
    std::vector<std::complex<T>> turns, shifts;

    explicit Plan(Index count) : count(count) {
        Index left = count;
        for (const Index factor : {4, 2, 3, 5})
            for (; left % factor == 0; left /= factor) {
                factors.push_back(factor);
                for (Index p = 0; p < left / factor; p++)
                    for (Index k = 1; k < factor; k++) turns.push_back(turn(2.0 * p * k / left));
            }
        if (left != 1) throw std::invalid_argument("lengths must be products of 2, 3 and 5");
        for (Index j = 0; j < count; j++) shifts.push_back(turn(1.0 * j / count));
    }

    static std::complex<T> turn(double part) {
        constexpr double PI = 3.14159265358979323846;
        return std::complex<T>(std::polar(1.0, -PI * part));
    }
};

template <Index R, class T>
INLINED static void butterfly(Lines<T> *a) {
    if constexpr (R == 2) {
        const Lines<T> b = a[1];
        a[1] = {a[0].re - b.re, a[0].im - b.im};
        a[0] = {a[0].re + b.re, a[0].im + b.im};
    } else if constexpr (R == 4) {
        const Lines<T> even[2] = {{a[0].re + a[2].re, a[0].im + a[2].im},
                                  {a[1].re + a[3].re, a[1].im + a[3].im}};
        const Lines<T> odd[2] = {{a[0].re - a[2].re, a[0].im - a[2].im},
                                 {a[1].re - a[3].re, a[1].im - a[3].im}};
        a[0] = {even[0].re + even[1].re, even[0].im + even[1].im};
        a[1] = {odd[0].re + odd[1].im, odd[0].im - odd[1].re};
        a[2] = {even[0].re - even[1].re, even[0].im - even[1].im};
        a[3] = {odd[0].re - odd[1].im, odd[0].im + odd[1].re};
    } else {
        // Of an odd number of terms: those of two opposite frequencies are alike but for signs.
        constexpr Index H = R / 2;
        constexpr double COS[3][2] = {{-0.5, 0}, {}, {0.30901699437494742, -0.80901699437494742}};
        constexpr double SIN[3][2] = {
            {0.86602540378443865, 0}, {}, {0.95105651629515357, 0.58778525229247313}};
        Lines<T> sum[H], difference[H], first = a[0];
        for (Index j = 0; j < H; j++) {
            sum[j] = {a[1 + j].re + a[R - 1 - j].re, a[1 + j].im + a[R - 1 - j].im};
            difference[j] = {a[1 + j].re - a[R - 1 - j].re, a[1 + j].im - a[R - 1 - j].im};
            a[0] = {a[0].re + sum[j].re, a[0].im + sum[j].im};
        }
        for (Index k = 1; k <= H; k++) {
            Lines<T> even = first, odd = {};
            for (Index j = 0; j < H; j++) {
                const Index turns = (j + 1) * k % R, place = std::min(turns, R - turns) - 1;
                const T c = COS[R - 3][place], s = (turns > H ? -1 : 1) * SIN[R - 3][place];
                even = {even.re + c * sum[j].re, even.im + c * sum[j].im};
                odd = {odd.re + s * difference[j].re, odd.im + s * difference[j].im};
            }
            a[k] = {even.re + odd.im, even.im - odd.re};
            a[R - k] = {even.re - odd.im, even.im + odd.re};
        }
    }
}

// One factor of a transform after Stockham, which leaves the frequencies in their order.
template <Index R, class T>
INLINED static void pass(Index left, Index done, const std::complex<T> *turns,
                         const Lines<T> *RESTRICT from, Lines<T> *RESTRICT to) {
    for (Index p = 0; p < left / R; p++)
        for (Index q = 0; q < done; q++) {
            Lines<T> a[R];
            for (Index j = 0; j < R; j++) a[j] = from[q + done * (p + left / R * j)];
            butterfly<R>(a);
            to[q + done * R * p] = a[0];
            for (Index k = 1; k < R; k++) {
                const std::complex<T> by = turns[(R - 1) * p + k - 1];
                to[q + done * (R * p + k)] = a[k].turned(by.real(), by.imag());
            }
        }
}

// The transform of some lines, which are overwritten: in one of the two buffers.
template <class T>
INLINED static Lines<T> *transformed(const Plan<T> &plan, Lines<T> *lines, Lines<T> *other) {
    Index left = plan.count, done = 1;
    const std::complex<T> *turns = plan.turns.data();
    for (const Index factor : plan.factors) {
        if (factor == 4) pass<4>(left, done, turns, lines, other);
        if (factor == 2) pass<2>(left, done, turns, lines, other);
        if (factor == 3) pass<3>(left, done, turns, lines, other);
        if (factor == 5) pass<5>(left, done, turns, lines, other);
        turns += left / factor * (factor - 1);
        left /= factor;
        done *= factor;
        std::swap(lines, other);
    }
    return lines;
}

VECTORIZED static Lines<float> *transform(const Plan<float> &plan, Lines<float> *lines,
                                          Lines<float> *other) {
    return transformed(plan, lines, other);
}
VECTORIZED static Lines<double> *transform(const Plan<double> &plan, Lines<double> *lines,
                                           Lines<double> *other) {
    return transformed(plan, lines, other);
}

template <class T>
INLINED static Vector<T> loaded(const T *from, Index count) {
    Vector<T> result = {};
    if (count >= LANES<T>) std::memcpy(&result, from, sizeof result);
    else if (count > 0) std::memcpy(&result, from, count * sizeof(T));
    return result;
}

template <class T>
INLINED static void store(const Vector<T> &vector, T *to, Index count) {
    if (count >= LANES<T>) std::memcpy(to, &vector, sizeof vector);
    else if (count > 0) std::memcpy(to, &vector, count * sizeof(T));
}

// Turn rows of a square of vectors into columns: exchange its blocks, then those of each block.
template <Index D, class T, Index... L>
INLINED static void exchange(Vector<T> *rows, std::integer_sequence<Index, L...>) {
    constexpr Index N = sizeof...(L);
    for (Index i = 0; i < N; i++) {
        if (i & D) continue;
        const Vector<T> one = rows[i], other = rows[i + D];
        rows[i] = __builtin_shufflevector(one, other, (L & D ? N + L - D : L)...);
        rows[i + D] = __builtin_shufflevector(one, other, (L & D ? N + L : L + D)...);
    }
}

template <class T>
INLINED static void transpose(Vector<T> *rows) {
    constexpr auto lanes = std::make_integer_sequence<Index, LANES<T>>();
    if constexpr (LANES<T> == 8) exchange<4, T>(rows, lanes);
    exchange<2, T>(rows, lanes);
    exchange<1, T>(rows, lanes);
}

// The transform of lines and, if asked for, that at the frequencies between: in some of four buffers.
template <class T>
INLINED static std::array<Lines<T> *, 4> branches(const Plan<T> &plan, Lines<T> *work, bool odd) {
    const Index n = plan.count;
    Lines<T> *shifted = work + 2 * n;
    if (odd)
        for (Index j = 0; j < n; j++)
            shifted[j] = work[j].turned(plan.shifts[j].real(), plan.shifts[j].imag());
    Lines<T> *even = transform(plan, work, work + n);
    Lines<T> *between = odd ? transform(plan, shifted, work + 3 * n) : shifted;
    return {even, even == work ? work + n : work, between,
            between == shifted ? work + 3 * n : shifted};
}

// The inverse of both, of which the conjugates are given, but for the number of terms: conjugate, too.
template <class T>
INLINED static Lines<T> *joined(const Plan<T> &plan, std::array<Lines<T> *, 4> at, bool odd) {
    Lines<T> *result = transform(plan, at[0], at[1]);
    if (!odd) return result;
    const Lines<T> *between = transform(plan, at[2], at[3]);
    for (Index j = 0; j < plan.count; j++) {
        const Lines<T> part = between[j].turned(plan.shifts[j].real(), plan.shifts[j].imag());
        result[j] = {result[j].re + part.re, result[j].im + part.im};
    }
    return result;
}

// A field by frequency along x: the real parts in the first rows, the imaginary ones in those that
// mirror them, both twice. Of columns from a place on, as many as two vectors have.
template <class T>
INLINED static void into_rows(const Plan<T> &plan, Index columns, Index column, const T *field,
                              T *even, T *odd, Lines<T> *work) {
    const Index n = plan.count, width = LANES<T>;
    const Index first = columns - column, second = first - width;
    for (Index j = 0; j < n; j++) {
        const T *at = field + j * columns + column;
        work[j] = {loaded(at, first), loaded(at + width, second)};
    }
    const auto found = branches(plan, work, odd);
    for (Index branch = 0; branch < (odd ? 2 : 1); branch++) {
        const Lines<T> *lines = found[2 * branch];
        T *rows = (branch ? odd : even) + column;
        for (Index k = 0; k <= n / 2 - branch; k++) {
            const Index mirror = branch ? n - 1 - k : (n - k) % n;
            const Lines<T> one = lines[k], other = lines[mirror];
            store<T>(one.re + other.re, rows + k * columns, first);
            store<T>(one.im + other.im, rows + k * columns + width, second);
            if (k == mirror) continue;
            store<T>(one.im - other.im, rows + mirror * columns, first);
            store<T>(other.re - one.re, rows + mirror * columns + width, second);
        }
    }
}

// The inverse, of what is given once.
template <class T>
INLINED static void from_rows(const Plan<T> &plan, Index columns, Index column, T *field,
                              const T *odd, Lines<T> *work) {
    const Index n = plan.count, width = LANES<T>;
    const Index first = columns - column, second = first - width;
    for (Index branch = 0; branch < (odd ? 2 : 1); branch++) {
        const T *rows = (branch ? odd : field) + column;
        Lines<T> *lines = work + 2 * branch * n;
        for (Index k = 0; k <= n / 2 - branch; k++) {
            const Index mirror = branch ? n - 1 - k : (n - k) % n;
            const Lines<T> real = {loaded(rows + k * columns, first),
                                   loaded(rows + k * columns + width, second)};
            Lines<T> imaginary = {};
            if (k != mirror)
                imaginary = {loaded(rows + mirror * columns, first),
                             loaded(rows + mirror * columns + width, second)};
            lines[k] = {real.re - imaginary.im, -real.im - imaginary.re};
            lines[mirror] = {real.re + imaginary.im, imaginary.re - real.im};
        }
    }
    const Lines<T> *result = joined(plan, {work, work + n, work + 2 * n, work + 3 * n}, odd);
    for (Index j = 0; j < n; j++) {
        T *at = field + j * columns + column;
        store<T>(result[j].re, at, first);
        store<T>(-result[j].im, at + width, second);
    }
}

// Multiply the transforms along y of as many lines as a vector has lanes by spectra, which are given
// for half of the frequencies by lane.
template <class T>
INLINED static void multiply_lines(const Plan<T> &plan, Index rows, bool is_odd, Index line, T *field,
                                   const T *even, const T *odd, Lines<T> *work) {
    const Index n = plan.count, width = LANES<T>, count = rows / 2 + (is_odd ? 0 : 1);
    T *real[LANES<T>] = {}, *imaginary[LANES<T>] = {};
    for (Index l = 0; l < std::min(width, count - line); l++) {
        const Index row = line + l, mirror = is_odd ? rows - 1 - row : (rows - row) % rows;
        real[l] = field + row * n;
        if (mirror != row) imaginary[l] = field + mirror * n;
    }
    Vector<T> re[LANES<T>], im[LANES<T>];
    for (Index first = 0; first < n; first += width) {
        for (Index l = 0; l < width; l++) {
            re[l] = loaded(real[l] + first, real[l] ? n - first : 0);
            im[l] = loaded(imaginary[l] + first, imaginary[l] ? n - first : 0);
        }
        transpose<T>(re);
        transpose<T>(im);
        for (Index l = 0; l < std::min(width, n - first); l++) work[first + l] = {re[l], im[l]};
    }
    const auto found = branches(plan, work, odd);
    for (Index branch = 0; branch < (odd ? 2 : 1); branch++) {
        const T *spectrum = branch ? odd : even;
        Lines<T> *lines = found[2 * branch];
        for (Index k = 0; k < n; k++) {
            const Index place = std::min(k, n - branch - k);
            const Vector<T> factor = loaded(spectrum + place * width, width);
            lines[k] = {lines[k].re * factor, -lines[k].im * factor};
        }
    }
    const Lines<T> *result = joined(plan, found, odd);
    for (Index first = 0; first < n; first += width) {
        for (Index l = 0; l < width; l++) {
            const Lines<T> each = first + l < n ? result[first + l] : Lines<T>{};
            re[l] = each.re;
            im[l] = -each.im;
        }
        transpose<T>(re);
        transpose<T>(im);
        for (Index l = 0; l < width; l++) {
            store<T>(re[l], real[l] + first, real[l] ? n - first : 0);
            store<T>(im[l], imaginary[l] + first, imaginary[l] ? n - first : 0);
        }
    }
}

#define FOR_BOTH(T)                                                                                  \
    VECTORIZED static void to_rows(const Plan<T> &plan, Index columns, Index column, const T *field, \
                                   T *even, T *odd, Lines<T> *work) {                                \
        into_rows(plan, columns, column, field, even, odd, work);                                    \
    }                                                                                                \
    VECTORIZED static void to_field(const Plan<T> &plan, Index columns, Index column, T *field,      \
                                    const T *odd, Lines<T> *work) {                                  \
        from_rows(plan, columns, column, field, odd, work);                                          \
    }                                                                                                \
    VECTORIZED static void by_spectra(const Plan<T> &plan, Index rows, bool is_odd, Index line,      \
                                      T *field, const T *even, const T *odd, Lines<T> *work) {       \
        multiply_lines(plan, rows, is_odd, line, field, even, odd, work);                            \
    }
FOR_BOTH(float)
FOR_BOTH(double)

// The convolution on a window of some shape, or its part at the frequencies of the window repeated.
template <class T>
class Window {
  public:
    Window(Index rows, Index columns) : along_x(rows), along_y(columns) {}

    // Spectra by branch of the frequency along x and along y; those of odd ones may be missing.
    void convolve(Threads &threads, const Field<const T> &field,
                  const std::vector<Field<const T>> &spectra, const Field<T> &result) {
        const Index rows = along_x.count, columns = along_y.count, width = LANES<T>;
        require(rows % 2 == 0 && columns % 2 == 0, "a window must have even numbers of cells");
        for (const auto &each : {field.size(), result.size()})
            require(each == rows * columns, "fields must be of the window's shape");
        const bool both = spectra.size() == 4;
        require(both || spectra.size() == 1, "there must be one spectrum or four");
        const Index lines[2] = {rows / 2 + 1, rows / 2}, terms[2] = {columns / 2 + 1, columns / 2};
        for (Index i = 0; i < static_cast<Index>(spectra.size()); i++)
            require(spectra[i].size() >= blocks(lines[i / 2], width) * terms[i % 2] * width,
                    "spectra must be of the window's frequencies");
        const py::gil_scoped_release while_others_compute;
        if (both) between.resize(rows * columns);
        T *odd = both ? between.data() : nullptr;
        const Index strips = blocks(columns, 2 * width), even_lines = blocks(lines[0], width);
        // Threads work far apart, because two columns may lie in one line of the cache.
        const auto column = [=](Index part) {
            return (part % 2 ? (strips + 1) / 2 + part / 2 : part / 2) * 2 * width;
        };
        threads.share(strips, [&](Index part) {
            to_rows(along_x, columns, column(part), field.data, result.data, odd, room());
        });
        threads.share(even_lines + (both ? blocks(lines[1], width) : 0), [&](Index part) {
            const bool is_odd = part >= even_lines;
            const Index block = is_odd ? part - even_lines : part;
            const auto spectrum = [&](Index branch) {
                return spectra[2 * is_odd + branch].data + block * terms[branch] * width;
            };
            by_spectra(along_y, rows, is_odd, block * width, is_odd ? odd : result.data, spectrum(0),
                       both ? spectrum(1) : nullptr, room());
        });
        threads.share(strips, [&](Index part) {
            to_field(along_x, columns, column(part), result.data, odd, room());
        });
    }

  private:
    const Plan<T> along_x, along_y;
    std::vector<T> between;

    static Index blocks(Index count, Index size) { return (count + size - 1) / size; }

    // Buffers of a thread.
    Lines<T> *room() const {
        thread_local std::vector<Lines<T>> lines;
        lines.resize(std::max<std::size_t>(lines.size(), 4 * std::max(along_x.count, along_y.count)));
        return lines.data();
    }
};

template <class T>
static void bind_window(py::module_ &module, const char *name) {
    py::class_<Window<T>>(module, name)
        .def(py::init<Index, Index>())
        .def("convolve", &Window<T>::convolve)
        .def_property_readonly_static("lanes", [](py::object) { return LANES<T>; });
}
#endif

PYBIND11_MODULE(compiled_kernels, module) {
#if defined(__GLIBC__)
    // Fields are made and dropped all the time: memory of the size of some is kept for the next.
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
#endif
    module.doc() = "The functions of kernels.py, compiled.";
    module.attr("source") = KERNELS_SHA256;
    py::class_<Threads>(module, "Threads").def(py::init<int>()).def("each", &Threads::each);
#if defined(TRANSFORMS)
    if (__builtin_cpu_supports("avx2")) {
        bind_window<float>(module, "SingleWindow");
        bind_window<double>(module, "DoubleWindow");
    }
#endif
    module.def("product", &product);
    bind(module, "inner", &inner32);
    bind(module, "inner", &inner64);
    bind(module, "total", &total);
    bind(module, "largest", &largest32);
    bind(module, "largest", &largest64);
    bind(module, "times", &times);
    bind(module, "times", &times_number);
    bind(module, "project_mean", &project_mean);
    bind(module, "weigh", &weigh);
    bind(module, "update_direction", &update_direction);
    bind(module, "add_layer", &add_layer);
    bind(module, "advance", &advance);
    bind(module, "recover_displacement", &recover_displacement);
    bind(module, "scale_and_clip", &scale_and_clip);
    bind(module, "level", &level);
    bind(module, "evaluate", &evaluate);
    bind(module, "scale_step", &scale_step);
    bind(module, "descent", &descent);
    bind(module, "move", &move);
    bind(module, "wear", &wear);
    bind(module, "wear_slope", &wear_slope);
}
