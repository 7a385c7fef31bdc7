// Arithmetic on the cells between two transforms, compiled: see kernels.py for what each function is.
//
// Every kernel is a loop that the compiler turns into vector instructions, on x86-64 with glibc in
// one version for each generation of processors, chosen when the library is loaded. Sums are taken
// over blocks of cells and the blocks added in double precision. Bounds are written so that what is
// not a number stays so.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
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
        const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(100);
        do {
            for (int look = 0; look < 100; look++)
                if (holds()) return;
            std::this_thread::yield();
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

template <class F>
INLINED static float largest_of(Index n, F value) {
    float largest = 0;
#pragma omp simd reduction(max : largest)
    for (Index i = 0; i < n; i++) {
        const float magnitude = std::fabs(value(i));
        largest = magnitude > largest ? magnitude : largest;
    }
    return largest;
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

PYBIND11_MODULE(compiled_kernels, module) {
    module.doc() = "The functions of kernels.py, compiled.";
    module.attr("source") = KERNELS_SHA256;
    py::class_<Threads>(module, "Threads").def(py::init<int>()).def("each", &Threads::each);
    bind(module, "inner", &inner32);
    bind(module, "inner", &inner64);
    bind(module, "total", &total);
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
