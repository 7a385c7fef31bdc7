// Toroidal functions and their means over rings, of `fretwear.mechanics.geometry.harmonics`.

#pragma once

#include "threads.h"

// Points at a time, means by which an arithmetic-geometric one converges, χ − 1 up to which Q follows
// from those of lower degree (arcosh χ = 0.3), and number of degrees above the largest one from which
// ratios of successive ones, beyond, converge downward.
constexpr Index SOME = 64, MEANS = 9, ABOVE = 60;
constexpr double HALF_PI = 1.57079632679489661923, FORWARD = 0.0453385141;

// Q_{−½}, and Q_{n−½} − Q_{−½} for n = 0 … degrees in rows of SOME, by χ − 1.
VECTORIZED static void toroidal(const double *RESTRICT apart, Index degrees, double *RESTRICT lowest,
                                double *RESTRICT beyond, double *RESTRICT ratios) {
    double chi[SOME], ratio[SOME] = {}, farthest = 0.0;
#pragma omp simd reduction(max : farthest)
    for (Index i = 0; i < SOME; i++) {
        const double by = apart[i], below = 2.0 + by;
        const bool touches = by == 0.0;
        double geometric = std::sqrt((touches ? 1.0 : by) / below), mean = 1.0, power = 0.5;
        double total = 0.5 * (1.0 - geometric) * (1.0 + geometric);
        for (Index step = 0; step < MEANS; step++) {
            const double half = 0.5 * (mean - geometric);
            geometric = std::sqrt(mean * geometric);
            mean -= half;
            power *= 2.0;
            total += power * half * half;
        }
        const double first = HALF_PI / mean, second = first * (1.0 - total);
        const double start = std::sqrt(2.0 / below) * first;
        chi[i] = 1.0 + by;
        lowest[i] = touches ? 0.0 : start;
        beyond[i] = 0.0;
        beyond[SOME + i] = touches ? -2.0 : by * start - std::sqrt(2.0 * below) * second;
        farthest = by > farthest ? by : farthest;
    }
    // (n + ½) Q_{n+½} = 2 n χ Q_{n−½} − (n − ½) Q_{n−3/2}
    for (Index n = 1; n < degrees; n++) {
        const double *RESTRICT before = beyond + (n - 1) * SOME, *RESTRICT here = before + SOME;
        double *RESTRICT after = beyond + (n + 1) * SOME;
        const double two = 2.0 * n, less = n - 0.5, scale = 1.0 / (n + 0.5);
#pragma omp simd
        for (Index i = 0; i < SOME; i++)
            after[i] = (two * (chi[i] * here[i] + apart[i] * lowest[i]) - less * before[i]) * scale;
    }
    if (!(farthest > FORWARD)) return;
    for (Index n = degrees + ABOVE; n > 0; n--) {
        const double two = 2.0 * n, less = n - 0.5, more = n + 0.5;
        double *RESTRICT kept = ratios + std::min(n, degrees) * SOME;
#pragma omp simd
        for (Index i = 0; i < SOME; i++) {
            ratio[i] = less / (two * chi[i] - more * ratio[i]);
            kept[i] = ratio[i];
        }
    }
    std::fill_n(ratio, SOME, 1.0);
    for (Index n = 1; n <= degrees; n++) {
        const double *RESTRICT next = ratios + n * SOME;
        double *RESTRICT here = beyond + n * SOME;
#pragma omp simd
        for (Index i = 0; i < SOME; i++) {
            ratio[i] *= next[i];
            here[i] = apart[i] > FORWARD ? lowest[i] * (ratio[i] - 1.0) : here[i];
        }
    }
}

// Both for a row of χ − 1: Q_{−½} first, then the differences, by degree.
static py::array_t<double> toroidal_functions(const Field<const double> &apart, Index degrees) {
    require(degrees > 0, "there must be a degree above zero");
    py::array_t<double> result({degrees + 2, apart.size()});
    double *data = result.mutable_data();
    std::vector<double> beyond((degrees + 1) * SOME), ratios(beyond.size());
    for (Index first = 0; first < apart.size(); first += SOME) {
        const Index number = std::min(SOME, apart.size() - first);
        double some[SOME] = {}, lowest[SOME];
        std::copy_n(apart.data + first, number, some);
        toroidal(some, degrees, lowest, beyond.data(), ratios.data());
        std::copy_n(lowest, number, data + first);
        for (Index n = 0; n <= degrees; n++)
            std::copy_n(beyond.data() + n * SOME, number, data + (n + 1) * apart.size() + first);
    }
    return result;
}

// Terms of the kernels at some points beside one, for waves up to `count`: in rows of SOME, first the
// even functions 0 … 2 count, then the even and the odd part of those of odd degree.
VECTORIZED static void wave_terms(Index count, const double *RESTRICT apart,
                                  const double *RESTRICT slope, const double *RESTRICT factor,
                                  const double *RESTRICT lowest, const double *RESTRICT beyond,
                                  double *RESTRICT terms) {
    for (Index wave = 0; wave <= count; wave++) {
        const double *RESTRICT there = beyond + 2 * wave * SOME;
        double *RESTRICT along = terms + wave * SOME;
#pragma omp simd
        for (Index i = 0; i < SOME; i++) along[i] = factor[i] * there[i];
    }
    for (Index wave = 0; wave < count; wave++) {
        const Index odd = 2 * wave + 1;
        const double *RESTRICT before = beyond + (odd - 1) * SOME, *RESTRICT there = before + SOME;
        double *RESTRICT even = terms + (count + 1 + wave) * SOME, *RESTRICT turns = even + count * SOME;
        const double more = 2.0 * odd, less = more - 1.0;
#pragma omp simd
        for (Index i = 0; i < SOME; i++) {
            const double whole = there[i] + lowest[i];
            even[i] = factor[i] * (less * before[i] - more * (there[i] + apart[i] * whole));
            turns[i] = factor[i] * odd * slope[i] * whole;
        }
    }
}

// Means of these terms over rings, shape (3 count + 1, n, n), from points of Gauss: their radii and
// their shares of a ring in two rows, by the first of each ring.
static py::array_t<double> ring_means(const Field<const double> &points,
                                      const Field<const int64_t> &starts, Index count) {
    require(points.rows == 2 && count > 0, "points must have radii and shares");
    const Index total = points.columns, rings = starts.size(), terms = 3 * count + 1;
    const double *radius = points.data, *share = points.data + total;
    py::array_t<double> result({terms, rings, rings});
    double *means = result.mutable_data();
    const py::gil_scoped_release while_others_compute;
    std::fill_n(means, terms * rings * rings, 0.0);
    std::vector<Index> ring(total);
    for (Index i = 0; i < rings; i++) {
        const Index end = i + 1 < rings ? starts.data[i + 1] : total;
        require(0 <= starts.data[i] && starts.data[i] <= end && end <= total, "rings must be in order");
        std::fill(ring.begin() + starts.data[i], ring.begin() + end, i);
    }
    std::vector<double> beyond((2 * count + 1) * SOME), ratios(beyond.size()), values(terms * SOME);
    double apart[SOME], slope[SOME], factor[SOME], lowest[SOME];
    for (Index point = 0; point < total; point++) {
        const double r = radius[point];
        double *row = means + ring[point] * rings;
        for (Index first = starts.data[ring[point]]; first < total; first += SOME) {
            const Index number = std::min(SOME, total - first);
            for (Index i = 0; i < SOME; i++) {
                const double s = i < number ? radius[first + i] : r;
                apart[i] = (r - s) * (r - s) / (2.0 * r * s);
                slope[i] = r / s - s / r;
                factor[i] = i < number ? 2.0 * share[point] * share[first + i] / std::sqrt(r * s) : 0.0;
            }
            toroidal(apart, 2 * count, lowest, beyond.data(), ratios.data());
            wave_terms(count, apart, slope, factor, lowest, beyond.data(), values.data());
            for (Index term = 0; term < terms; term++)
                for (Index i = 0; i < number; i++)
                    row[term * rings * rings + ring[first + i]] += values[term * SOME + i];
        }
    }
    for (Index term = 0; term < terms; term++) {
        double *field = means + term * rings * rings;
        const double sign = term > 2 * count ? -1.0 : 1.0;
        for (Index i = 0; i < rings; i++)
            for (Index j = 0; j < i; j++) field[i * rings + j] = sign * field[j * rings + i];
    }
    return result;
}

// Invert symmetric, positive definite matrices of some rows in place, by sweeps of their lower halves,
// some rows and columns at a time.
constexpr Index PIVOTS = 4;

template <class T>
INLINED static inline void sweep_one(Index n, T *RESTRICT matrix, Index k) {
    const T per_pivot = T(1) / matrix[k * n + k];
    for (Index i = 0; i < n; i++)
        for (Index j = 0; j < n && i != k; j++)
            if (j != k) matrix[i * n + j] -= matrix[i * n + k] * matrix[k * n + j] * per_pivot;
    for (Index i = 0; i < n; i++)
        if (i != k) matrix[i * n + k] = matrix[k * n + i] = matrix[k * n + i] * per_pivot;
    matrix[k * n + k] = -per_pivot;
}

template <class T>
VECTORIZED static void sweep(Index n, T *RESTRICT matrix, T *RESTRICT columns) {
    for (Index first = 0; first < n; first += PIVOTS) {
        // A block of fewer rows is completed by ones that nothing couples.
        const Index end = std::min(first + PIVOTS, n);
        T pivot[PIVOTS * PIVOTS] = {};
        for (Index a = 0; a < PIVOTS; a++) {
            T *RESTRICT column = columns + a * n;
            pivot[a * PIVOTS + a] = 1;
            std::fill_n(column, n, T(0));
            if (first + a >= end) continue;
            for (Index j = 0; j < first; j++) column[j] = matrix[(first + a) * n + j];
            for (Index i = end; i < n; i++) column[i] = matrix[i * n + first + a];
            for (Index b = 0; b <= a; b++)
                pivot[a * PIVOTS + b] = pivot[b * PIVOTS + a] = matrix[(first + a) * n + first + b];
        }
        for (Index k = 0; k < PIVOTS; k++) sweep_one<T>(PIVOTS, pivot, k);
        const T *RESTRICT c0 = columns, *RESTRICT c1 = c0 + n, *RESTRICT c2 = c1 + n, *RESTRICT c3 = c2 + n;
        for (Index i = 0; i < n; i++) {
            T factors[PIVOTS], *RESTRICT row = matrix + i * n;
            for (Index a = 0; a < PIVOTS; a++) {
                factors[a] = 0;
                for (Index b = 0; b < PIVOTS; b++) factors[a] += pivot[a * PIVOTS + b] * columns[b * n + i];
            }
            const T f0 = factors[0], f1 = factors[1], f2 = factors[2], f3 = factors[3];
#pragma omp simd
            for (Index j = 0; j <= i; j++)
                row[j] += f0 * c0[j] + f1 * c1[j] + f2 * c2[j] + f3 * c3[j];
            if (i >= first && i < end) continue;
            for (Index a = first; a < end; a++)
                (i < first ? matrix[a * n + i] : row[a]) = -factors[a - first];
        }
        for (Index a = first; a < end; a++)
            for (Index b = first; b <= a; b++)
                matrix[a * n + b] = pivot[(a - first) * PIVOTS + b - first];
    }
    for (Index i = 0; i < n; i++)
        for (Index j = 0; j <= i; j++) matrix[i * n + j] = matrix[j * n + i] = -matrix[i * n + j];
}

template <class T>
static void invert(const Field<T> &matrices) {
    const Index n = matrices.columns;
    require(n > 0 && matrices.rows % n == 0, "matrices must be square");
    std::vector<T> columns(PIVOTS * n);
    const py::gil_scoped_release while_others_compute;
    for (Index first = 0; first < matrices.rows; first += n)
        sweep(n, matrices.data + first * n, columns.data());
}

// Sums of rows of a length by factors.
template <class T>
VECTORIZED static void mix(Index targets, Index sources, Index n, const T *RESTRICT factors,
                           const T *RESTRICT rows, T *RESTRICT result) {
    for (Index target = 0; target < targets; target++) {
        T *RESTRICT row = result + target * n;
        std::fill_n(row, n, T(0));
        for (Index source = 0; source < sources; source++) {
            const T factor = factors[target * sources + source], *RESTRICT other = rows + source * n;
#pragma omp simd
            for (Index i = 0; i < n; i++) row[i] += factor * other[i];
        }
    }
}

// Add the product of a row with the first of the rows of a matrix.
template <class T>
VECTORIZED static void add_product(Index n, Index length, const T *RESTRICT matrix,
                                   const T *RESTRICT row, T *RESTRICT result) {
    for (Index i = 0; i < n; i++) {
        const T *RESTRICT factors = matrix + i * length;
        T sum = 0;
#pragma omp simd reduction(+ : sum)
        for (Index j = 0; j < n; j++) sum += factors[j] * row[j];
        result[i] += sum;
    }
}

// Waves of tractions on rings at several angles, of n rings. A field has a row for each angle, or two
// if it has two components. Matrices of all waves are in rows below each other.
template <class T>
class Waves {
   public:
    Waves(const Field<const T> &to, const Field<const T> &from, Index n)
        : _rows(to.columns), _waves(to.rows), _n(n), _to(to.data), _from(from.data), _there(_waves * n),
          _here(_waves * n) {
        require(from.rows == _rows && from.columns == _waves, "waves and angles must fit");
    }

    // Each wave moved by its own matrix: one for each wave or, of the waves 1 … m, 0 … 1 − m and −m of
    // shear, one for each number; and those of shear, but for the last, by 1 less themselves.
    void displace(const Field<const T> &own, const Field<const T> *other, const T *field, T *result) {
        const Index length = own.columns, size = length * length, most = (_waves - 1) / 2;
        const bool numbered = own.rows == (most + 1) * length;
        require(length >= _n && (numbered || own.rows == _waves * length)
                    && (!other || (other->rows == 2 * most * length && other->columns == length)),
                "there must be a matrix for each wave");
        mix(_waves, _rows, _n, _to, field, _there.data());
        std::fill(_here.begin(), _here.end(), T(0));
        for (Index wave = 0; wave < _waves; wave++) {
            const Index paired = wave < most ? wave + most : wave - most;
            const Index number = !numbered ? wave : wave < most ? wave + 1 : paired;
            T *moved = _here.data() + wave * _n;
            add_product(_n, length, own.data + number * size, _there.data() + wave * _n, moved);
            if (other && wave < 2 * most)
                add_product(_n, length, other->data + wave * size, _there.data() + paired * _n, moved);
        }
        mix(_rows, _waves, _n, _from, _here.data(), result);
    }

   private:
    const Index _rows, _waves, _n;
    const T *_to, *_from;  // amplitudes of waves by rows, (waves, rows), and back, (rows, waves)
    std::vector<T> _there, _here;
};

// Displacement by a pressure or a shear traction on rings at several angles, see `Waves`.
template <class T>
static void displace_waves(const Field<const T> &own, const std::optional<Field<const T>> &other,
                        const Field<const T> &to, const Field<const T> &from,
                        const Field<const T> &field, const Field<T> &result) {
    require(field.rows == to.columns && result.rows == to.columns
                && result.columns == field.columns,
            "fields must be of one shape");
    const py::gil_scoped_release while_others_compute;
    Waves<T>(to, from, result.columns)
        .displace(own, other ? &*other : nullptr, field.data, result.data);
}

// Sum of products of two fields, by the shares of angles.
static double shared(Index angles, Index n, const float *shares, const float *one, const float *other) {
    double sum = 0.0;
    for (Index angle = 0; angle < angles; angle++)
        sum += shares[angle] * inner<float>(n, one + angle * n, other + angle * n);
    return sum;
}

// Conjugate gradients for pressures on free cells that cause displacements, of which fields follow
// each other and become the solutions. `layer` is a compliance of cells and `inside` 1 in free ones, 0
// elsewhere; the inverses precondition, and `added` on rings that they lack. The result is the largest
// number of iterations.
static Index solve_on_rings(const Field<const float> &matrices, const Field<const float> &inverses,
                            const Field<const float> &to, const Field<const float> &from,
                            const Field<const float> &added, const Field<const float> &shares,
                            const Field<const float> &layer, const Field<const float> &inside, double reduction, Index most,
                            const Field<float> &fields) {
    const Index n = fields.columns, angles = layer.rows, size = n * angles;
    require(layer.columns == n && inside.size() == size && shares.size() == angles
                && added.size() == n && to.columns == angles && fields.size() % size == 0,
            "fields must be of one shape");
    const py::gil_scoped_release while_others_compute;
    Waves<float> waves(to, from, n);
    std::vector<float> left(size), direction(size), force(size);
    const auto product = [&](const std::vector<float> &one, const std::vector<float> &other) {
        return shared(angles, n, shares.data, one.data(), other.data());
    };
    Index taken = 0;
    for (float *found = fields.data; found < fields.data + fields.size(); found += size) {
        for (Index i = 0; i < size; i++) left[i] = found[i] * inside.data[i];
        std::fill_n(found, size, 0.0f);
        std::fill(direction.begin(), direction.end(), 0.0f);
        const double enough = reduction * reduction * product(left, left);
        double energy = 1.0;
        for (Index step = 0; step < most && product(left, left) > enough; step++) {
            taken = std::max(taken, step + 1);
            waves.displace(inverses, nullptr, left.data(), force.data());
            for (Index row = 0; row < size; row += n)
                for (Index i = 0; i < n; i++)
                    force[row + i] = inside.data[row + i] * (force[row + i] + added.data[i] * left[row + i]);
            const double before = energy;
            energy = product(left, force);
            const float ratio = step ? static_cast<float>(energy / before) : 0.0f;
            for (Index i = 0; i < size; i++) direction[i] = force[i] + ratio * direction[i];
            waves.displace(matrices, nullptr, direction.data(), force.data());
            for (Index i = 0; i < size; i++)
                force[i] = inside.data[i] * (force[i] + layer.data[i] * direction[i]);
            const double work = product(direction, force);
            if (!(work > 0.0)) break;
            const float length = static_cast<float>(energy / work);
            for (Index i = 0; i < size; i++) {
                found[i] += length * direction[i];
                left[i] -= length * force[i];
            }
        }
    }
    return taken;
}
