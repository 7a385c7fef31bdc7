// Arithmetic on the cells between two transforms, where going over them once pays, compiled as the
// module `fretwear.mechanics.kernels`.
//
// Fields are contiguous and of one shape; a kernel changes only its last argument or those that its
// comment names, and keeps none. The first argument of a call from Python is the `Team` whose threads
// share the cells. Every kernel is a loop that the compiler turns into vector instructions, on x86-64
// with glibc in one version for each generation of processors, chosen when the library is loaded. A
// kernel sees one block of cells at a time, and what it returns of each is put together in double
// precision. Bounds are written so that what is not a number stays so.

#include "threads.h"
#include "transforms.h"

// The product of two matrices, row by row, each in pieces that stay in the cache's first level, by the
// thread that calls. The threads of BLAS would gain nothing here, hinder cases that run in parallel,
// and make the last bits depend on their number.
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

// Compile a loop for both, whether a field is given or not.
template <class F>
INLINED static inline auto whether(const void *is_given, F loop) {
    return is_given ? loop(std::true_type()) : loop(std::false_type());
}

// Compile a loop for both, one limit of pressure and one for each cell.
template <class F>
INLINED static inline auto limited(Limit limit, F loop) {
    if (limit.data) return loop([limits = limit.data](Index i) INLINED { return limits[i]; });
    return loop([limit = limit.value](Index) INLINED { return limit; });
}

// Sum over a block of what a function gives for each cell, in the precision of T.
template <class T, class F>
INLINED static inline T sum_of(Index n, F term) {
    T sum = 0;
#pragma omp simd reduction(+ : sum)
    for (Index i = 0; i < n; i++) sum += term(i);
    return sum;
}

// Sum of the products of two fields.
template <class T>
VECTORIZED static double inner(Index n, const T *a, const T *b) {
    return sum_of<T>(n, [=](Index i) { return a[i] * b[i]; });
}

#include "harmonics.h"

// Largest magnitude in a field.
template <class T>
VECTORIZED static double largest(Index n, const T *field) {
    T largest = 0;
#pragma omp simd reduction(max : largest)
    for (Index i = 0; i < n; i++) {
        const T magnitude = std::fabs(field[i]);
        largest = magnitude > largest ? magnitude : largest;
    }
    return largest;
}

// Multiply a field by another one or by a number.
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

// Conjugate gradients.

// Subtract a shift from a residual; return the sum of its squares where `inside` is 1.
VECTORIZED static double project_mean(Index n, float shift, const float *RESTRICT inside,
                                      float *RESTRICT residual) {
    return sum_of<float>(n, [=](Index i) {
        residual[i] -= shift;
        return residual[i] * residual[i] * inside[i];
    });
}

// Multiply a field by a weight; return its inner product with a residual.
VECTORIZED static double weigh(Index n, const float *RESTRICT weight, const float *RESTRICT residual,
                               float *RESTRICT field) {
    return sum_of<float>(n, [=](Index i) { return (field[i] *= weight[i]) * residual[i]; });
}

// Form the next direction: a field plus a multiple of the last one.
VECTORIZED static void update_direction(Index n, float factor, const float *RESTRICT field,
                                        float *RESTRICT direction) {
#pragma omp simd
    for (Index i = 0; i < n; i++) direction[i] = factor * direction[i] + field[i];
}

// Add tangent times direction to a force; return the inner product of direction and force.
VECTORIZED static double add_layer(Index n, Maybe<float> tangent, const float *RESTRICT direction,
                                   float *RESTRICT force) {
    const float *RESTRICT layer = tangent.data;
    return whether(layer, [=](auto layered) INLINED {
        return sum_of<float>(n, [=](Index i) {
            if (layered) force[i] += layer[i] * direction[i];
            return force[i] * direction[i];
        });
    });
}

// Add a direction to `pressure`, take its force from `residual`; return weight times residual.
VECTORIZED static double advance(Index n, float length, const float *RESTRICT direction,
                                 const float *RESTRICT force, const float *RESTRICT weight,
                                 float *RESTRICT pressure, float *RESTRICT residual) {
    return sum_of<float>(n, [=](Index i) {
        pressure[i] += length * direction[i];
        residual[i] -= length * force[i];
        return residual[i] * weight[i];
    });
}

// Replace a residual by the half-space displacement of the pressure that led to it: the residual at the
// start, minus this one, a shift and the part of the tangent. Return the sum of the pressure.
VECTORIZED static double recover_displacement(Index n, const float *RESTRICT start,
                                              Maybe<float> tangent, const float *RESTRICT pressure,
                                              float shift, float *RESTRICT residual) {
    const float *RESTRICT layer = tangent.data;
    return whether(layer, [=](auto layered) INLINED {
        return sum_of<double>(n, [=](Index i) {
            const float moved = start[i] - residual[i] - shift;
            residual[i] = layered ? moved - layer[i] * pressure[i] : moved;
            return pressure[i];
        });
    });
}

// The active set.

// Scale a pressure and clip it to 0 … `limit`, except on cells at the limit if these are `rigid`; return
// the weighted sums of the pressure and of the cells at the limit.
VECTORIZED static std::array<double, 2> scale_and_clip(Index n, double factor, Limit limit, bool rigid,
                                                       Maybe<double> weights,
                                                       double *RESTRICT pressure) {
    const double *RESTRICT weight = weights.data;
    return limited(limit, [=](auto limit) INLINED {
        return whether(weight, [=](auto weighted) INLINED -> std::array<double, 2> {
            double carried = 0, saturated = 0;
#pragma omp simd reduction(+ : carried, saturated)
            for (Index i = 0; i < n; i++) {
                const double before = pressure[i], unit = weighted ? weight[i] : 1.0;
                double value = before * factor;
                value = value < 0 ? 0 : value;
                value = value > limit(i) ? limit(i) : value;
                value = rigid & (before >= limit(i)) ? before : value;
                pressure[i] = value;
                carried += unit * value;
                saturated += value >= limit(i) ? unit : 0.0;
            }
            return {carried, saturated};
        });
    });
}

// Sum of separations and count of cells with 0 < p < `limit`; largest displacement of all.
VECTORIZED static std::array<double, 3> level(Index n, Limit limit, const double *RESTRICT separation,
                                              const double *RESTRICT displacement,
                                              const double *RESTRICT pressure) {
    return limited(limit, [=](auto limit) INLINED -> std::array<double, 3> {
        double sum = 0, count = 0, highest = -INFINITE;
#pragma omp simd reduction(+ : sum, count) reduction(max : highest)
        for (Index i = 0; i < n; i++) {
            const double free = (pressure[i] > 0) & (pressure[i] < limit(i)) ? 1.0 : 0.0;
            sum += free * separation[i];
            count += free;
            highest = displacement[i] > highest ? displacement[i] : highest;
        }
        return {sum, count, highest};
    });
}

// Gap of a pressure, and the cells to free: those between the bounds, those at zero that interpenetrate
// and those at the limit that separate, both by more than a margin. Return the largest violation of
// g = 0 between the bounds, of g ≥ 0 where p = 0 and of g ≤ 0 at the limit, and the sum of all gaps,
// which tells of values that are not numbers.
VECTORIZED static std::array<double, 2> evaluate(Index n, const double *RESTRICT separation,
                                                 const double *RESTRICT pressure, Limit limit,
                                                 double approach, double slack, double *RESTRICT gap,
                                                 bool *RESTRICT to_be_free) {
    return limited(limit, [=](auto limit) INLINED -> std::array<double, 2> {
        double worst = 0, sum = 0;
#pragma omp simd reduction(+ : sum) reduction(max : worst)
        for (Index i = 0; i < n; i++) {
            const double value = separation[i] - approach;
            gap[i] = value;
            sum += value;
            double violation = pressure[i] >= limit(i) ? value : std::fabs(value);
            violation = pressure[i] > 0 ? violation : -value;
            worst = violation > worst ? violation : worst;
            const bool open = pressure[i] <= 0, saturated = pressure[i] >= limit(i);
            const bool closes = value < -slack, parts = value > slack;
            to_be_free[i] = (open & closes) | (saturated & parts) | !(open | saturated);
        }
        return {worst, sum};
    });
}

// The step `found` in some unit, minus a part of a uniform one. Return the lowest pressure that it leads
// to, the highest one less `limit`, and its product with the gap.
VECTORIZED static std::array<double, 3> scale_step(Index n, const double *RESTRICT pressure,
                                                   const double *RESTRICT gap,
                                                   const float *RESTRICT found, double unit,
                                                   const float *RESTRICT uniform, double share,
                                                   Limit limit, double *RESTRICT step) {
    return limited(limit, [=](auto limit) INLINED -> std::array<double, 3> {
        double lowest = INFINITE, highest = -INFINITE, along = 0;
#pragma omp simd reduction(+ : along) reduction(min : lowest) reduction(max : highest)
        for (Index i = 0; i < n; i++) {
            const double value = found[i] * unit - uniform[i] * share;
            step[i] = value;
            const double target = pressure[i] + value, above = target - limit(i);
            lowest = target < lowest ? target : lowest;
            highest = above > highest ? above : highest;
            along += value * gap[i];
        }
        return {lowest, highest, along};
    });
}

// Add a fraction of a step to `pressure`, without leading beyond 0 and `limit` by rounding, and its
// displacement, `moved` in some unit plus an offset, to `displacement`; set the separation to that plus
// the shape.
VECTORIZED static void move(Index n, double fraction, const double *RESTRICT step, Limit limit,
                            const float *RESTRICT moved, double unit, double offset,
                            const double *RESTRICT shape, double *RESTRICT pressure,
                            double *RESTRICT displacement, double *RESTRICT separation) {
    const double part = fraction * unit, shift = fraction * offset;
    limited(limit, [=](auto limit) INLINED {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            double target = pressure[i] + fraction * step[i];
            target = target < 0 ? 0 : target;
            pressure[i] = target > limit(i) ? limit(i) : target;
            const double value = displacement[i] + part * moved[i] + shift;
            displacement[i] = value;
            separation[i] = value + shape[i];
        }
    });
}

// The wear of a stage, see `fretwear.mechanics.slip.WearLayer`.

// eˣ − 1 as 2ᵏ (eʳ − 1) + (2ᵏ − 1) with x = k ln 2 + r and the Taylor series of eʳ − 1, |r| < 0.35:
// good to two units in the last place, for x up to 700 in magnitude.
INLINED static inline double expm1_of(double x) {
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
    constexpr double FACTORIALS[] = {479001600.0, 39916800.0, 3628800.0, 362880.0, 40320.0, 5040.0,
                                     720.0,       120.0,      24.0,      6.0,      2.0};
    double series = 1.0 / 6227020800.0;
    for (const double factorial : FACTORIALS) series = series * r + 1.0 / factorial;
    series = series * r * r + r;
    return power * series + (power - 1.0);
}

INLINED static inline double exponent_of(double pressure, double rate, double known) {
    const double x = rate * pressure + known;
    return x > 200.0 ? 200.0 : x;
}

// Add the wear depth: W₀ plus (eˣ − 1) g*₀ + ΔG (φ(x) − 1), if not negative, with
// φ − 1 = (eˣ − 1 − x)/x, which is zero at zero.
VECTORIZED static void wear(Index n, const double *RESTRICT pressure, double rate,
                            const double *RESTRICT known, const double *RESTRICT start,
                            const double *RESTRICT reduced_gap, Maybe<double> flow,
                            double *RESTRICT result) {
    const double *RESTRICT shift = flow.data;
    whether(shift, [=](auto flows) INLINED {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]), growth = expm1_of(x);
            double worn = growth * reduced_gap[i];
            if (flows) {
                worn += (growth - x) / (x < 1e-12 ? 1e-12 : x) * shift[i];
                worn = worn < 0 ? 0 : worn;
            }
            result[i] += worn + start[i];
        }
    });
}

// The derivative of `wear` by the exponent, times a factor, not negative. There φ' = (eˣ − φ)/x loses
// its digits near zero, where it is a line of slope 1/3.
VECTORIZED static void wear_slope(Index n, const double *RESTRICT pressure, double rate,
                                  const double *RESTRICT known, const double *RESTRICT reduced_gap,
                                  Maybe<double> flow, double factor, float *RESTRICT result) {
    constexpr double LARGEST = 1e30, SMALL = 3e-5;
    const double *RESTRICT shift = flow.data;
    whether(shift, [=](auto flows) INLINED {
#pragma omp simd
        for (Index i = 0; i < n; i++) {
            const double x = exponent_of(pressure[i], rate, known[i]);
            const double above = flows && x < SMALL ? SMALL : x, growth = expm1_of(above);
            double slope = (growth + 1.0) * reduced_gap[i];
            if (flows) {
                const double per_above = 1.0 / above;
                const double phi_slope = ((above - growth) * per_above + growth) * per_above;
                const double below = x < SMALL ? (x - SMALL) / 3.0 : 0.0;
                slope += (phi_slope + below) * shift[i];
                slope = slope < 0 ? 0 : slope;
            }
            slope *= factor;
            result[i] = static_cast<float>(slope > LARGEST ? LARGEST : slope);
        }
    });
}

PYBIND11_MODULE(kernels, module) {
#if defined(__GLIBC__)
    // Fields are made and dropped all the time: memory of the size of some is kept for the next.
    mallopt(M_MMAP_THRESHOLD, 1 << 25);
    mallopt(M_TRIM_THRESHOLD, 1 << 28);
#endif
    module.attr("source") = SOURCE_SHA256;
    module.attr("compiler") = COMPILER;
    module.attr("processor") = processor();
    py::class_<Threads>(module, "Threads")
        .def(py::init<int>(), py::arg("workers") = 1)
        .def_readonly("workers", &Threads::workers)
        .def("each", &Threads::each);
    bind_window<float>(module, "SingleWindow");
    bind_window<double>(module, "DoubleWindow");
    module.def("product", &product);
    module.def("toroidal_functions", &toroidal_functions);
    module.def("ring_means", &ring_means);
    module.def("invert", &invert<float>);
    module.def("invert", &invert<double>);
    module.def("displace_waves", &displace_waves<float>);
    module.def("displace_waves", &displace_waves<double>);
    module.def("solve_on_rings", &solve_on_rings);
    bind<plus>(module, "inner", &inner<float>);
    bind<plus>(module, "inner", &inner<double>);
    bind<most>(module, "largest", &largest<float>);
    bind<most>(module, "largest", &largest<double>);
    bind(module, "times", &times);
    bind(module, "times", &times_number);
    bind<plus>(module, "project_mean", &project_mean);
    bind<plus>(module, "weigh", &weigh);
    bind(module, "update_direction", &update_direction);
    bind<plus>(module, "add_layer", &add_layer);
    bind<plus>(module, "advance", &advance);
    bind<plus>(module, "recover_displacement", &recover_displacement);
    bind<plus, plus>(module, "scale_and_clip", &scale_and_clip);
    bind<plus, plus, most>(module, "level", &level);
    bind<most, plus>(module, "evaluate", &evaluate);
    bind<least, most, plus>(module, "scale_step", &scale_step);
    bind(module, "move", &move);
    bind(module, "wear", &wear);
    bind(module, "wear_slope", &wear_slope);
}
