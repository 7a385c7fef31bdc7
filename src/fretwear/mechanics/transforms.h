// Convolution of a field on a window that is even along neither axis: see convolution.py.
//
// Several lines are transformed at a time, one in each lane of a vector. Spectra of the kernel are real
// and even: two columns are the real and the imaginary part of one line, and what belongs to a frequency
// along x is a line of complex numbers along y, whose parts lie in a row and in the one that mirrors it.
// Where a processor's vectors are shorter, the compiler takes several.

#pragma once

#include "threads.h"

#if defined(PLAIN)
template <class T>
struct Lanes {
    T at[32 / sizeof(T)];

    T &operator[](Index lane) { return at[lane]; }
    const T &operator[](Index lane) const { return at[lane]; }
    template <class Of>
    Lanes each(Of of) const {
        Lanes made;
        for (Index lane = 0; lane < Index(32 / sizeof(T)); lane++) made[lane] = of(lane);
        return made;
    }
    Lanes operator+(const Lanes &b) const { return each([&](Index i) { return at[i] + b[i]; }); }
    Lanes operator-(const Lanes &b) const { return each([&](Index i) { return at[i] - b[i]; }); }
    Lanes operator-() const { return each([&](Index i) { return -at[i]; }); }
    Lanes operator*(T c) const { return each([&](Index i) { return at[i] * c; }); }
    Lanes operator*(const Lanes &b) const { return each([&](Index i) { return at[i] * b[i]; }); }
};
template <class T>
struct VectorOf {
    using type = Lanes<T>;
};
#else
template <class T>
struct VectorOf {
    typedef T type __attribute__((vector_size(32)));
};
#endif
template <class T>
using Vector = typename VectorOf<T>::type;
template <class T>
constexpr Index LANES = 32 / sizeof(T);

// A complex number of each line, or a real one of each of twice as many.
template <class T>
struct Lines {
    alignas(32) Vector<T> re;
    alignas(32) Vector<T> im;

    INLINED inline Lines operator+(const Lines &b) const { return {re + b.re, im + b.im}; }
    INLINED inline Lines operator-(const Lines &b) const { return {re - b.re, im - b.im}; }
    INLINED inline Lines operator*(T c) const { return {re * c, im * c}; }
    INLINED inline Lines operator*(const std::complex<T> &b) const {
        const T c = b.real(), s = b.imag();
        return {re * c - im * s, im * c + re * s};
    }
    INLINED inline Lines conjugate() const { return {re, -im}; }
    // By a quarter, clockwise.
    INLINED inline Lines turned() const { return {im, -re}; }
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
            for (; left > 0 && left % factor == 0; left /= factor) {
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
INLINED static inline void butterfly(Lines<T> *a) {
    if constexpr (R == 2) {
        const Lines<T> b = a[1];
        a[1] = a[0] - b;
        a[0] = a[0] + b;
    } else if constexpr (R == 4) {
        const Lines<T> even[2] = {a[0] + a[2], a[1] + a[3]}, odd[2] = {a[0] - a[2], a[1] - a[3]};
        a[0] = even[0] + even[1];
        a[1] = odd[0] + odd[1].turned();
        a[2] = even[0] - even[1];
        a[3] = odd[0] - odd[1].turned();
    } else {
        // Of an odd number of terms: those of two opposite frequencies are alike but for signs.
        constexpr Index H = R / 2;
        constexpr double COS[3][2] = {{-0.5, 0}, {}, {0.30901699437494742, -0.80901699437494742}};
        constexpr double SIN[3][2] = {
            {0.86602540378443865, 0}, {}, {0.95105651629515357, 0.58778525229247313}};
        Lines<T> sum[H], difference[H], first = a[0];
        for (Index j = 0; j < H; j++) {
            sum[j] = a[1 + j] + a[R - 1 - j];
            difference[j] = a[1 + j] - a[R - 1 - j];
            a[0] = a[0] + sum[j];
        }
        for (Index k = 1; k <= H; k++) {
            Lines<T> even = first, odd = {};
            for (Index j = 0; j < H; j++) {
                const Index turns = (j + 1) * k % R, place = std::min(turns, R - turns) - 1;
                even = even + sum[j] * COS[R - 3][place];
                odd = odd + difference[j] * ((turns > H ? -1 : 1) * SIN[R - 3][place]);
            }
            a[k] = even + odd.turned();
            a[R - k] = even - odd.turned();
        }
    }
}

// One factor of a transform after Stockham, which leaves the frequencies in their order.
template <Index R, class T>
INLINED static inline void pass(Index left, Index done, const std::complex<T> *turns,
                         const Lines<T> *RESTRICT from, Lines<T> *RESTRICT to) {
    for (Index p = 0; p < left / R; p++)
        for (Index q = 0; q < done; q++) {
            Lines<T> a[R];
            for (Index j = 0; j < R; j++) a[j] = from[q + done * (p + left / R * j)];
            butterfly<R>(a);
            to[q + done * R * p] = a[0];
            for (Index k = 1; k < R; k++)
                to[q + done * (R * p + k)] = a[k] * turns[(R - 1) * p + k - 1];
        }
}

// Transform some lines, by turns into the other buffer and back: the two are exchanged.
template <class T>
VECTORIZED static void transform(const Plan<T> &plan, Lines<T> *&lines, Lines<T> *&other) {
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
}

template <class T>
INLINED static inline Vector<T> loaded(const T *from, Index count) {
    Vector<T> result = {};
    if (count >= LANES<T>) std::memcpy(&result, from, sizeof result);
    else if (count > 0) std::memcpy(&result, from, count * sizeof(T));
    return result;
}

// Two vectors of a row, of which a number of cells are left.
template <class T>
INLINED static inline Lines<T> loaded_pair(const T *from, Index left) {
    return {loaded(from, left), loaded(from + LANES<T>, left - LANES<T>)};
}

template <class T>
INLINED static inline void store(const Vector<T> &vector, T *to, Index count) {
    if (count >= LANES<T>) std::memcpy(to, &vector, sizeof vector);
    else if (count > 0) std::memcpy(to, &vector, count * sizeof(T));
}

template <class T>
INLINED static inline void store_pair(const Lines<T> &pair, T *to, Index left) {
    store<T>(pair.re, to, left);
    store<T>(pair.im, to + LANES<T>, left - LANES<T>);
}

// Some lanes of two vectors, by their numbers.
template <class T, Index... L>
INLINED static inline Vector<T> lanes_of(const Vector<T> &one, const Vector<T> &other) {
#if defined(PLAIN)
    return {(L < LANES<T> ? one[L % LANES<T>] : other[L % LANES<T>])...};
#elif defined(__clang__)
    return __builtin_shufflevector(one, other, L...);
#else
    using Lane = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
    return __builtin_shuffle(one, other, typename VectorOf<Lane>::type{L...});
#endif
}

// Turn rows of a square of vectors into columns: exchange its blocks, then those of each block.
template <Index D, class T, Index... L>
INLINED static inline void swap_blocks(Vector<T> *rows, std::integer_sequence<Index, L...>) {
    constexpr Index N = sizeof...(L);
    for (Index i = 0; i < N; i++) {
        if (i & D) continue;
        const Vector<T> one = rows[i], other = rows[i + D];
        rows[i] = lanes_of<T, (L & D ? N + L - D : L)...>(one, other);
        rows[i + D] = lanes_of<T, (L & D ? N + L : L + D)...>(one, other);
    }
}

template <class T>
INLINED static inline void transpose(Vector<T> *rows) {
    constexpr auto lanes = std::make_integer_sequence<Index, LANES<T>>();
    if constexpr (LANES<T> == 8) swap_blocks<4, T>(rows, lanes);
    swap_blocks<2, T>(rows, lanes);
    swap_blocks<1, T>(rows, lanes);
}

// The transform of lines and, if asked for, that at the frequencies between: in the first and the third
// of four buffers.
template <class T>
using Buffers = std::array<Lines<T> *, 4>;
template <class T>
INLINED static inline void split(const Plan<T> &plan, Buffers<T> &at, bool odd) {
    if (odd)
        for (Index j = 0; j < plan.count; j++) at[2][j] = at[0][j] * plan.shifts[j];
    transform(plan, at[0], at[1]);
    if (odd) transform(plan, at[2], at[3]);
}

// The inverse of both, of which the conjugates are given, but for the number of terms: conjugate, too.
template <class T>
INLINED static inline void combine(const Plan<T> &plan, Buffers<T> &at, bool odd) {
    transform(plan, at[0], at[1]);
    if (!odd) return;
    transform(plan, at[2], at[3]);
    for (Index j = 0; j < plan.count; j++) at[0][j] = at[0][j] + at[2][j] * plan.shifts[j];
}

// A field by frequency along x: the real parts in the first rows, the imaginary ones in those that
// mirror them, both twice. Of columns from a place on, as many as two vectors have.
template <class T>
VECTORIZED static void into_rows(const Plan<T> &plan, Index columns, Index column, const T *field,
                                 T *even, T *odd, Buffers<T> at) {
    const Index n = plan.count, left = columns - column;
    for (Index j = 0; j < n; j++) at[0][j] = loaded_pair(field + j * columns + column, left);
    split(plan, at, odd);
    for (Index is_odd = 0; is_odd < (odd ? 2 : 1); is_odd++) {
        const Lines<T> *lines = at[2 * is_odd];
        T *rows = (is_odd ? odd : even) + column;
        for (Index k = 0; k <= n / 2 - is_odd; k++) {
            const Index mirror = is_odd ? n - 1 - k : (n - k) % n;
            const Lines<T> one = lines[k], other = lines[mirror];
            store_pair(one + other, rows + k * columns, left);
            if (k != mirror) store_pair((one - other).turned(), rows + mirror * columns, left);
        }
    }
}

// The inverse, of what is given once.
template <class T>
VECTORIZED static void from_rows(const Plan<T> &plan, Index columns, Index column, T *field,
                                 const T *odd, Buffers<T> at) {
    const Index n = plan.count, left = columns - column;
    for (Index is_odd = 0; is_odd < (odd ? 2 : 1); is_odd++) {
        const T *rows = (is_odd ? odd : field) + column;
        Lines<T> *lines = at[2 * is_odd];
        for (Index k = 0; k <= n / 2 - is_odd; k++) {
            const Index mirror = is_odd ? n - 1 - k : (n - k) % n;
            const Lines<T> real = loaded_pair(rows + k * columns, left);
            Lines<T> imaginary = {};
            if (k != mirror) imaginary = loaded_pair(rows + mirror * columns, left);
            lines[k] = (real - imaginary.turned()).conjugate();
            lines[mirror] = (real + imaginary.turned()).conjugate();
        }
    }
    combine(plan, at, odd);
    for (Index j = 0; j < n; j++)
        store_pair(at[0][j].conjugate(), field + j * columns + column, left);
}

// The real and imaginary parts, by rows of a field, of as many lines along y as a vector has lanes; none
// beyond the last.
template <class T>
struct Rows {
    T *real[LANES<T>] = {}, *imaginary[LANES<T>] = {};

    Rows(T *field, Index rows, Index columns, bool is_odd, Index line) {
        const Index count = rows / 2 + (is_odd ? 0 : 1);
        for (Index l = 0; l < std::min(LANES<T>, count - line); l++) {
            const Index row = line + l, mirror = is_odd ? rows - 1 - row : (rows - row) % rows;
            real[l] = field + row * columns;
            if (mirror != row) imaginary[l] = field + mirror * columns;
        }
    }

    INLINED inline void load(Lines<T> *lines, Index n) const {
        constexpr Index width = LANES<T>;
        Vector<T> re[width], im[width];
        for (Index first = 0; first < n; first += width) {
            for (Index l = 0; l < width; l++) {
                re[l] = loaded(real[l] + first, real[l] ? n - first : 0);
                im[l] = loaded(imaginary[l] + first, imaginary[l] ? n - first : 0);
            }
            transpose<T>(re);
            transpose<T>(im);
            for (Index l = 0; l < std::min(width, n - first); l++) lines[first + l] = {re[l], im[l]};
        }
    }

    // Store the conjugates.
    INLINED inline void store_conjugates(const Lines<T> *lines, Index n) const {
        constexpr Index width = LANES<T>;
        Vector<T> re[width], im[width];
        for (Index first = 0; first < n; first += width) {
            for (Index l = 0; l < width; l++) {
                const Lines<T> each = first + l < n ? lines[first + l] : Lines<T>{};
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
};

// Spectra of a block of lines, for half of the frequencies by lane: at those of the window, and between.
template <class T>
using Branches = std::array<const T *, 2>;

// Multiply the transforms along y of a block of lines by spectra.
template <class T>
VECTORIZED static void multiply_lines(const Plan<T> &plan, const Rows<T> &rows,
                                      const Branches<T> &spectra, Buffers<T> at) {
    const Index n = plan.count, width = LANES<T>;
    const bool odd = spectra[1] != nullptr;
    rows.load(at[0], n);
    split(plan, at, odd);
    for (Index between = 0; between < (odd ? 2 : 1); between++) {
        Lines<T> *lines = at[2 * between];
        for (Index k = 0; k < n; k++) {
            const Index place = std::min(k, n - between - k);
            const Vector<T> factor = loaded(spectra[between] + place * width, width);
            lines[k] = {lines[k].re * factor, -lines[k].im * factor};
        }
    }
    combine(plan, at, odd);
    rows.store_conjugates(at[0], n);
}

// The same for lines of two fields, by spectra of either and one, odd along both axes and of opposite
// sign, of one by the other.
template <class T>
VECTORIZED static void multiply_pairs(const Plan<T> &plan, const std::array<Rows<T>, 2> &rows,
                                      const std::array<Branches<T>, 3> &spectra,
                                      std::array<Buffers<T>, 2> at) {
    const Index n = plan.count, width = LANES<T>;
    const bool odd = spectra[0][1] != nullptr;
    for (Index i = 0; i < 2; i++) {
        rows[i].load(at[i][0], n);
        split(plan, at[i], odd);
    }
    for (Index between = 0; between < (odd ? 2 : 1); between++) {
        Lines<T> *first = at[0][2 * between], *second = at[1][2 * between];
        for (Index k = 0; k < n; k++) {
            const Index place = std::min(k, n - between - k) * width;
            Vector<T> factor[3];
            for (Index i = 0; i < 3; i++) factor[i] = loaded(spectra[i][between] + place, width);
            if (2 * k + between < n) factor[2] = -factor[2];
            const Lines<T> one = first[k], other = second[k];
            first[k] = {one.re * factor[0] + other.re * factor[2],
                        -(one.im * factor[0] + other.im * factor[2])};
            second[k] = {other.re * factor[1] + one.re * factor[2],
                         -(other.im * factor[1] + one.im * factor[2])};
        }
    }
    for (Index i = 0; i < 2; i++) {
        combine(plan, at[i], odd);
        rows[i].store_conjugates(at[i][0], n);
    }
}

// The convolution on a window of some shape, or its part at the frequencies of the window repeated.
template <class T>
class Window {
  public:
    Window(Index rows, Index columns) : along_x(rows), along_y(columns) {}

    // Spectra by branch of the frequency along x and along y; those of odd ones may be missing.
    void convolve(Threads &threads, const Field<const T> &field,
                  const std::vector<Field<const T>> &spectra, const Field<T> &result) {
        filter<1>(threads, field, spectra, result, [&](const auto &rows, const auto &factors) {
            multiply_lines(along_y, rows[0], factors[0], room(0));
        });
    }

    // Two fields into two, by three spectra of each branch: of either, and of one by the other.
    void convolve_pair(Threads &threads, const Field<const T> &pair,
                       const std::vector<Field<const T>> &spectra, const Field<T> &result) {
        filter<2>(threads, pair, spectra, result, [&](const auto &rows, const auto &factors) {
            multiply_pairs(along_y, rows, factors, {room(0), room(1)});
        });
    }

  private:
    const Plan<T> along_x, along_y;
    std::vector<T> between;

    static Index blocks(Index count, Index size) { return (count + size - 1) / size; }

    template <Index FIELDS, class Multiply>
    void filter(Threads &threads, const Field<const T> &fields,
                const std::vector<Field<const T>> &spectra, const Field<T> &result,
                const Multiply &multiply) {
        constexpr Index KERNELS = 2 * FIELDS - 1;
        const Index rows = along_x.count, columns = along_y.count, width = LANES<T>;
        require(rows % 2 == 0 && columns % 2 == 0, "a window must have even numbers of cells");
        for (const auto &each : {fields.size(), result.size()})
            require(each == FIELDS * rows * columns, "fields must be of the window's shape");
        const Index given = static_cast<Index>(spectra.size());
        const bool both = given == 4 * KERNELS;
        require(both || given == KERNELS, "there must be one spectrum or four of each kernel");
        const Index lines[2] = {rows / 2 + 1, rows / 2}, terms[2] = {columns / 2 + 1, columns / 2};
        for (Index i = 0; i < given; i++) {
            const Index branch = i / KERNELS;
            require(spectra[i].size() >= blocks(lines[branch / 2], width) * terms[branch % 2] * width,
                    "spectra must be of the window's frequencies");
        }
        const py::gil_scoped_release while_others_compute;
        const Index cells = rows * columns;
        if (both) between.resize(FIELDS * cells);
        T *odd = both ? between.data() : nullptr;
        const Index strips = blocks(columns, 2 * width), even_lines = blocks(lines[0], width);
        // Threads work far apart, because two columns may lie in one line of the cache.
        const auto column = [=](Index part) {
            return (part % 2 ? (strips + 1) / 2 + part / 2 : part / 2) * 2 * width;
        };
        threads.share(FIELDS * strips, [&](Index part) {
            const Index start = part / strips * cells;
            into_rows(along_x, columns, column(part % strips), fields.data + start,
                      result.data + start, odd ? odd + start : nullptr, room(0));
        });
        threads.share(even_lines + (both ? blocks(lines[1], width) : 0), [&](Index part) {
            const bool is_odd = part >= even_lines;
            const Index block = is_odd ? part - even_lines : part;
            std::array<Branches<T>, KERNELS> factors = {};
            for (Index branch = 0; branch < (both ? 2 : 1); branch++)
                for (Index i = 0; i < KERNELS; i++)
                    factors[i][branch] = spectra[(2 * is_odd + branch) * KERNELS + i].data +
                                         block * terms[branch] * width;
            const auto of = [&](Index i) {
                return Rows<T>((is_odd ? odd : result.data) + i * cells, rows, columns, is_odd,
                               block * width);
            };
            if constexpr (FIELDS == 1) multiply(std::array<Rows<T>, 1>{of(0)}, factors);
            else multiply(std::array<Rows<T>, 2>{of(0), of(1)}, factors);
        });
        threads.share(FIELDS * strips, [&](Index part) {
            const Index start = part / strips * cells;
            from_rows(along_x, columns, column(part % strips), result.data + start,
                      odd ? odd + start : nullptr, room(0));
        });
    }

    // Buffers of a thread, for one field and another.
    Buffers<T> room(Index field) const {
        thread_local std::array<std::vector<Lines<T>>, 2> buffers;
        std::vector<Lines<T>> &lines = buffers[field];
        const Index n = std::max(along_x.count, along_y.count);
        lines.resize(std::max<std::size_t>(lines.size(), 4 * n));
        return {&lines[0], &lines[n], &lines[2 * n], &lines[3 * n]};
    }
};

template <class T>
static void bind_window(py::module_ &module, const char *name) {
    py::class_<Window<T>>(module, name)
        .def(py::init<Index, Index>())
        .def("convolve", &Window<T>::convolve)
        .def("convolve_pair", &Window<T>::convolve_pair)
        .def_property_readonly_static("lanes", [](py::object) { return LANES<T>; });
}
