// What compiled kernels share: fields that come from Python, and threads.

#pragma once

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
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

// Sanitizers do not go with clones.
#if !defined(__clang__) && __GNUC__ >= 12 && defined(__x86_64__) && defined(__GLIBC__) \
    && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VECTORIZED __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define CLONED 1
#else
#define VECTORIZED
#define CLONED 0
#endif
#if defined(__clang__)
#define COMPILER "Clang " __clang_version__
#elif defined(__GNUC__)
#define COMPILER "GCC " __VERSION__
#elif defined(_MSC_VER)
#define COMPILER "Visual C++"
#else
#define COMPILER "unknown compiler"
#endif
// Visual C++ has neither vectors as types nor these attributes; PLAIN tries its path elsewhere.
#if defined(__GNUC__) && !defined(PLAIN)
#define RESTRICT __restrict__
#define INLINED __attribute__((always_inline))
#else
#define PLAIN 1
#define RESTRICT __restrict
#define INLINED
#endif

namespace py = pybind11;

using Index = py::ssize_t;
// The level of the processor for which the loops marked for vectors run.
inline const char* processor() {
#if CLONED
    __builtin_cpu_init();
    if (__builtin_cpu_supports("x86-64-v4")) return "x86-64-v4";
    if (__builtin_cpu_supports("x86-64-v3")) return "x86-64-v3";
#endif
    return "baseline";
}

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
// what may point to none is a field or None; what may differ between cells is a field or a number.
template <class T>
struct Maybe {
    const T *data;
};
struct Limit {
    const double *data;
    double value;
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
template <>
struct Argument<Limit> {
    using Given = std::variant<double, Field<const double>>;
    static Limit passed(const Given &given, Index first) {
        if (const auto *field = std::get_if<1>(&given)) return {field->data + first, 0.0};
        return {nullptr, std::get<0>(given)};
    }
    static Index size(const Given &given, Index n) {
        const auto *field = std::get_if<1>(&given);
        return field ? field->size() : n;
    }
};

// Threads that share the parts of a job, the caller's one of them. Passes over the cells follow each
// other within less time than it takes to wake a thread: one without work looks for some for a while
// before it sleeps.
class Threads {
  public:
    const int workers;

    explicit Threads(int workers) : workers(workers) {}

    ~Threads() {
        const py::gil_scoped_release while_they_end;
        ended = true;
        begin();
        for (auto &each : others) each.join();
    }

    // Call a function for each of so many parts, each thread holding something meanwhile; what it throws
    // is thrown here.
    template <class Held = int, class F>
    void share(Index parts, F function) {
        std::atomic<Index> next{0};
        const auto work = [&] {
            [[maybe_unused]] const Held held{};
            for (Index part; (part = next++) < parts;) function(part);
        };
        if (parts < 2 || workers < 2) return work();
        while (static_cast<int>(others.size()) < workers - 1) others.emplace_back([this] { serve(); });
        job = work;
        busy = workers - 1;
        begin();
        guarded();
        await([this] { return busy == 0; });
        if (error) std::rethrow_exception(std::exchange(error, nullptr));
    }

    // What a function of Python returns for each of some parts, in their order.
    py::list each(const py::function &function, const py::sequence &parts) {
        const auto number = static_cast<Index>(parts.size());
        py::list results(number);
        const py::gil_scoped_release while_others_compute;
        share<py::gil_scoped_acquire>(number, [&](Index part) {
            results[part] = function(py::object(parts[part]));
        });
        return results;
    }

  private:
    std::vector<std::thread> others;
    std::function<void()> job;
    std::exception_ptr error;
    std::atomic<bool> ended{false};
    std::atomic<unsigned> round{0};
    std::atomic<int> busy{0};
    std::mutex mutex;
    std::condition_variable changed;

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

// How the results of two parts become one.
static double plus(double one, double other) { return one + other; }
static double least(double one, double other) { return other < one ? other : one; }
static double most(double one, double other) { return other > one ? other : one; }

// A kernel is called for one block of cells after the other, in parts that threads share: the same for
// however many threads. What it returns of each is joined in their order, the blocks of a part first.
template <auto... JOIN, class R, class... P>
static void bind(py::module_ &module, const char *name, R (*kernel)(Index, P...)) {
    module.def(name, [kernel](Threads &threads, const typename Argument<P>::Given &...given) {
        using Results = std::array<double, sizeof...(JOIN)>;
        const Index n = std::max({Argument<P>::size(given, 0)...});
        require(((Argument<P>::size(given, n) == n) && ...), "fields must be of one shape");
        const Index share = n <= UNSHARED ? n : ((n - 1) / (PARTS * BLOCK) + 1) * BLOCK;
        const auto add = []([[maybe_unused]] Results &to, [[maybe_unused]] const Results &more) {
            [[maybe_unused]] std::size_t i = 0;
            ((to[i] = JOIN(to[i], more[i]), i++), ...);
        };
        std::vector<Results> results(n <= UNSHARED ? 1 : (n + share - 1) / share);
        {
            const py::gil_scoped_release while_others_compute;
            threads.share(results.size(), [&](Index part) {
                const Index start = part * share, end = std::min(start + share, n);
                for (Index first = start; first < end; first += BLOCK) {
                    const Index cells = std::min(BLOCK, end - first);
                    if constexpr (std::is_void_v<R>) {
                        kernel(cells, Argument<P>::passed(given, first)...);
                    } else {
                        const Results found = {kernel(cells, Argument<P>::passed(given, first)...)};
                        first == start ? void(results[part] = found) : add(results[part], found);
                    }
                }
            });
        }
        for (std::size_t part = 1; part < results.size(); part++) add(results[0], results[part]);
        if constexpr (sizeof...(JOIN) == 1) return results[0][0];
        if constexpr (sizeof...(JOIN) > 1) return results[0];
    });
}
