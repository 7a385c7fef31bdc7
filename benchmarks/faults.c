/* Preloaded into a process by faults.py. At each of its operations on the files of one folder the
   process forks, once for each fault: the child gets a copy of the folder in the place of the folder,
   fails there (or gets a signal) and goes on by itself; then the parent goes on as if nothing had
   happened. A record of all operations serves to replay them. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <limits.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { OPEN = 1, WRITE = 2, FSYNC = 4, RENAME = 8, MKDIR = 16, UNLINK = 32, TRUNCATE = 64, MEMORY = 128, LIBRARY = 256 };
enum { FILES = 4096, LARGE = 2048, PLACES = 1 << 18, SECONDS = 60, STACK = 1 << 20, CALLS = 24, OPENED = 256 };

#define MEMORY_FOLDER "/dev/shm"

struct fault { long kinds, error, sent, every, chosen; };

static char folder[PATH_MAX], copies[PATH_MAX];
static struct fault faults[32];
static int fault_count, record = -1, told = -1, heard = -1, armed, is_child, is_frozen;
static long operations[32], *outside;
static int serial_of[FILES], lock_of[FILES], serials;
static uint64_t places[PLACES], here; /* of what Python writes of its stack to no file */

void faults_arm(const char *below, const char *where, const struct fault *all, int count, int say, int hear,
                const char *log) {
    snprintf(folder, sizeof folder, "%s", below);
    snprintf(copies, sizeof copies, "%s", where);
    memcpy(faults, all, count * sizeof *all);
    fault_count = count, told = say, heard = hear;
    record = log[0] ? syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    outside = mmap(NULL, sizeof *outside, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    void *calls[1]; /* loads what it needs */
    backtrace(calls, 1);
    armed = 1;
}
void faults_disarm(void) { armed = 0; }
void faults_freeze(void) { is_frozen = 1; }
long faults_operations(int kind) { return operations[__builtin_ctz(kind)]; }
int faults_is_child(void) { return is_child; }

/* Whether memory is taken here for the first time: in the same lines of all functions of Python and, where no
   exception tells of it, by the same calls in the libraries below. */
static int is_new_place(int kind) {
    static void (*dump)(int, void *);
    static void *(*thread)(void);
    if (!dump) dump = dlsym(RTLD_DEFAULT, "_Py_DumpTraceback"), thread = dlsym(RTLD_DEFAULT, "PyGILState_GetThisThreadState");
    here = 14695981039346656037u + kind;
    void *calls[CALLS];
    armed = 0;
    dump(STACK, thread());
    if (kind != MEMORY) write(STACK, calls, backtrace(calls, CALLS) * sizeof *calls);
    armed = 1;
    uint64_t at = here % PLACES;
    while (places[at] && places[at] != here) at = (at + 1) % PLACES;
    int is_new = !places[at];
    places[at] = here;
    return is_new;
}

extern char **environ;

/* Puts a copy of the folder in its place for this process alone, with all that is open there. */
static void enter_copy(const char *copy) {
    static char of[OPENED][256];
    static struct stat nameless[OPENED];
    struct stat about;
    char link[64], said[PATH_MAX + 128];
    char *command[] = {"cp", "-a", folder, (char *)copy, NULL};
    pid_t copier;
    if (posix_spawnp(&copier, "cp", NULL, NULL, command, environ)) _exit(99);
    waitpid(copier, NULL, 0);
    for (int file = 3; file < OPENED; file++) {
        snprintf(link, sizeof link, "/proc/self/fd/%d", file);
        ssize_t n = readlink(link, of[file], sizeof of[file] - 1);
        of[file][n > 0 ? n : 0] = 0;
    }
    if (unshare(CLONE_NEWNS) || mount(NULL, "/", NULL, MS_REC | MS_PRIVATE, NULL) || mount(copy, folder, NULL, MS_BIND, NULL)
        || mount("none", MEMORY_FOLDER, "tmpfs", 0, NULL) || chdir(folder))
        _exit(98);
    /* Files elsewhere too, such as fonts: parent and child would move one position in them. */
    for (int file = 3; file < OPENED; file++) {
        if (of[file][0] != '/' || fstat(file, &about) || !S_ISREG(about.st_mode)) continue;
        int flags = fcntl(file, F_GETFL) & ~(O_CREAT | O_EXCL | O_TRUNC);
        int first = 3;
        while (first < file && (nameless[first].st_ino != about.st_ino || nameless[first].st_dev != about.st_dev)) first++;
        snprintf(link, sizeof link, "/proc/self/fd/%d", first);
        const char *name = first < file ? link : of[file];
        int is_kept = strncmp(name, MEMORY_FOLDER, strlen(MEMORY_FOLDER)) || strstr(name, " (deleted)");
        int same = syscall(SYS_openat, AT_FDCWD, name, (flags & ~O_TMPFILE) | (is_kept ? 0 : O_CREAT), 0600);
        if (same < 0 && (same = memfd_create("nameless", 0)) >= 0) /* has no name, or lost it */
            nameless[file] = about, is_kept = 0;
        static char block[1 << 16];
        ssize_t n;
        for (off_t at = 0; !is_kept && (n = syscall(SYS_pread64, file, block, sizeof block, at)) > 0; at += n)
            syscall(SYS_pwrite64, same, block, n, at);
        syscall(SYS_lseek, same, syscall(SYS_lseek, file, 0, SEEK_CUR), SEEK_SET);
        syscall(SYS_dup3, same, file, O_CLOEXEC);
        syscall(SYS_close, same);
        if (lock_of[file]) syscall(SYS_flock, file, lock_of[file] | LOCK_NB);
    }
    snprintf(said, sizeof said, "%s.said", copy);
    int log = syscall(SYS_openat, AT_FDCWD, said, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(log, 1), dup2(log, 2);
}

/* Waits for a child, kills it if it hangs, and returns how it ended: its status, or minus the signal. */
static int ending_of(pid_t child, int *hung) {
    int status = 0;
    for (long waited = 0; !waitpid(child, &status, WNOHANG); waited++) {
        if (waited > SECONDS * 1000L) *hung = 1, kill(child, SIGKILL);
        usleep(1000);
    }
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

/* Forks; 1 in the child, 0 in the parent once the child has ended and that was told. */
static int branches(int fault, int kind, long number) {
    char copy[PATH_MAX + 64], line[256];
    int hung = 0;
    snprintf(copy, sizeof copy, "%s/%d-%d-%ld", copies, fault, kind, number);
    armed = 0, *outside = 0;
    pid_t child = fork();
    if (child == 0) {
        enter_copy(copy);
        return is_child = armed = 1;
    }
    int status = ending_of(child, &hung);
    int size = snprintf(line, sizeof line, "%d %d %ld %d %d %ld\n", fault, kind, number, status, hung, *outside);
    syscall(SYS_write, told, line, size);
    syscall(SYS_read, heard, line, 1);
    armed = 1;
    return 0;
}

static int fails(int kind) {
    if (!armed || is_child) return 0;
    long number = operations[__builtin_ctz(kind)]++;
    int is_wanted = 0;
    for (int fault = 0; fault < fault_count; fault++) is_wanted |= faults[fault].kinds & kind;
    /* Memory is refused once at each place. */
    if (!is_wanted || (kind >= MEMORY && !is_new_place(kind))) return 0;
    for (int fault = 0; fault < fault_count; fault++) {
        struct fault *what = faults + fault;
        if (!(what->kinds & kind) || what->chosen++ % what->every || !branches(fault, kind, number)) continue;
        if (what->sent) return kill(getpid(), what->sent), 0;
        return errno = what->error, 1;
    }
    return 0;
}

static void note(int kind, int serial, int64_t a, const char *one, const void *two, size_t size) {
    if (!armed || is_child || record < 0) return;
    int64_t head[5] = {kind, serial, a, (int64_t)strlen(one), (int64_t)size};
    syscall(SYS_write, record, head, sizeof head);
    syscall(SYS_write, record, one, strlen(one));
    syscall(SYS_write, record, two, size);
}

/* 1 for a path in the folder; what is changed elsewhere is counted. */
static int inside(int at, const char *path, char *whole, int changes) {
    char base[PATH_MAX] = "", link[64];
    if (!armed || !path) return 0;
    if (path[0] != '/') {
        snprintf(link, sizeof link, at == AT_FDCWD ? "/proc/self/cwd" : "/proc/self/fd/%d", at);
        ssize_t n = readlink(link, base, sizeof base - 2);
        if (n < 0) return 0;
        base[n] = '/', base[n + 1] = 0;
    }
    snprintf(whole, PATH_MAX, "%.2000s%.2000s", base, path);
    if (!strncmp(whole, folder, strlen(folder))) return 1;
    if (changes && strncmp(whole, "/dev/", 5) && strncmp(whole, "/proc/", 6)) ++*outside;
    return 0;
}

/* A process that starts and has not yet opened the file of its study: at each file that it opens
   it forks, once for each signal, and the child goes on with the signal. Before it has opened its
   own program Python answers in its own way. */
static char starting[PATH_MAX];
static int is_heard;
__attribute__((constructor)) static void read_environment(void) {
    const char *wanted = getenv("FAULTS_AT_START");
    if (wanted) snprintf(starting, sizeof starting, "%s", wanted);
}
static void signal_start(const char *path) {
    static long number;
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGKILL};
    if (!starting[0] || !path) return;
    if (strstr(path, ".yaml")) starting[0] = 0;
    is_heard |= strstr(path, "fretwear/cli/") && strstr(path, "/program.");
    for (int at = 0; is_heard && starting[0] && at < 4; at++) {
        char said[PATH_MAX + 64];
        int hung = 0;
        pid_t child = fork();
        snprintf(said, sizeof said, "%s/%ld-%d", starting, number, signals[at]);
        if (child == 0) {
            int log = syscall(SYS_openat, AT_FDCWD, said, O_WRONLY | O_CREAT | O_TRUNC, 0600);
            dup2(log, 1), dup2(log, 2);
            starting[0] = 0;
            kill(getpid(), signals[at]);
            return;
        }
        int status = ending_of(child, &hung);
        dprintf(2, "%ld %d %d %d\n", number, signals[at], status, hung);
    }
    number += is_heard;
}

static int opened(int at, const char *path, int flags, mode_t mode) {
    char whole[PATH_MAX];
    signal_start(path);
    int changes = (flags & (O_WRONLY | O_RDWR | O_CREAT | O_TRUNC)) != 0;
    int mine = inside(at, path, whole, changes);
    if (mine && fails(OPEN)) return -1;
    int file = syscall(SYS_openat, at, path, flags, mode);
    if (file >= 0 && file < FILES) {
        serial_of[file] = mine ? ++serials : 0, lock_of[file] = 0;
        if (mine) note(OPEN, serials, flags, whole, "", 0);
    }
    return file;
}
#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { \
        va_list list; \
        va_start(list, flags); \
        mode = va_arg(list, mode_t); \
        va_end(list); \
    }
int open(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { MODE return opened(AT_FDCWD, path, flags, mode); }
int openat(int at, const char *path, int flags, ...) { MODE return opened(at, path, flags, mode); }
int openat64(int at, const char *path, int flags, ...) { MODE return opened(at, path, flags, mode); }

static int serial(int file) { return armed && file >= 0 && file < FILES ? serial_of[file] : 0; }

int close(int file) {
    if (file >= 0 && file < FILES) serial_of[file] = lock_of[file] = 0;
    return syscall(SYS_close, file);
}
int flock(int file, int how) {
    int done = syscall(SYS_flock, file, how);
    if (serial(file) && !done) lock_of[file] = how & (LOCK_SH | LOCK_EX);
    return done;
}
ssize_t write(int file, const void *data, size_t size) {
    if (file == STACK) {
        for (size_t at = 0; at < size; at++) here = (here ^ ((const unsigned char *)data)[at]) * 1099511628211u;
        return size;
    }
    if (serial(file) && fails(WRITE)) return -1;
    ssize_t done = syscall(SYS_write, file, data, size);
    if (serial(file) && done > 0)
        note(WRITE, serial(file), syscall(SYS_lseek, file, 0, SEEK_CUR) - done, "", data, done);
    return done;
}
ssize_t pwrite64(int file, const void *data, size_t size, off64_t offset) {
    if (serial(file) && fails(WRITE)) return -1;
    ssize_t done = syscall(SYS_pwrite64, file, data, size, offset);
    if (serial(file) && done > 0) note(WRITE, serial(file), offset, "", data, done);
    return done;
}
ssize_t pwrite(int file, const void *data, size_t size, off_t offset) {
    return pwrite64(file, data, size, offset);
}
int fsync(int file) {
    if (serial(file) && fails(FSYNC)) return -1;
    if (serial(file)) note(FSYNC, serial(file), 0, "", "", 0);
    return serial(file) ? 0 : syscall(SYS_fsync, file);
}
int ftruncate64(int file, off64_t size) {
    if (serial(file) && fails(TRUNCATE)) return -1;
    int done = syscall(SYS_ftruncate, file, size);
    if (serial(file) && !done) note(TRUNCATE, serial(file), size, "", "", 0);
    return done;
}
int ftruncate(int file, off_t size) { return ftruncate64(file, size); }
int rename(const char *from, const char *to) {
    char one[PATH_MAX], two[PATH_MAX];
    int mine = inside(AT_FDCWD, from, one, 1) && inside(AT_FDCWD, to, two, 1);
    if (mine && fails(RENAME)) return -1;
    int done = syscall(SYS_rename, from, to);
    if (mine && !done) note(RENAME, 0, 0, one, two, strlen(two));
    return done;
}
int mkdir(const char *path, mode_t mode) {
    char whole[PATH_MAX];
    int mine = inside(AT_FDCWD, path, whole, 1);
    if (mine && fails(MKDIR)) return -1;
    int done = syscall(SYS_mkdir, path, mode);
    if (mine && !done) note(MKDIR, 0, 0, whole, "", 0);
    return done;
}
int unlink(const char *path) {
    char whole[PATH_MAX];
    int mine = inside(AT_FDCWD, path, whole, 1);
    if (mine && fails(UNLINK)) return -1;
    int done = syscall(SYS_unlink, path);
    if (mine && !done) note(UNLINK, 0, 0, whole, "", 0);
    return done;
}

/* Files that say when they were written would be different each second. */
int clock_gettime(clockid_t clock, struct timespec *now) {
    if (!is_frozen || clock != CLOCK_REALTIME) return syscall(SYS_clock_gettime, clock, now);
    now->tv_sec = 1900000000, now->tv_nsec = 0;
    return 0;
}
time_t time(time_t *now) {
    struct timespec found;
    clock_gettime(CLOCK_REALTIME, &found);
    return now ? *now = found.tv_sec : found.tv_sec;
}

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);

/* Python and NumPy are told of memory that is not there by all that use them; a library may fall over it. */
static int no_memory(size_t size, void *caller) {
    static struct { void *address; int kind; } known[PLACES];
    if (!armed || size < LARGE) return 0;
    size_t at = (uintptr_t)caller % PLACES;
    while (known[at].address && known[at].address != caller) at = (at + 1) % PLACES;
    if (!known[at].address) {
        Dl_info of = {0};
        const char *name = dladdr(caller, &of) && of.dli_fname ? of.dli_fname : "";
        int is_python = strstr(name, "/numpy/") || strstr(name, "libpython") || strstr(name, "bin/python");
        known[at].address = caller, known[at].kind = is_python ? MEMORY : LIBRARY;
    }
    return fails(known[at].kind);
}
#define NONE(size) no_memory(size, __builtin_return_address(0))
void *malloc(size_t size) { return NONE(size) ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return NONE(n * size) ? NULL : __libc_calloc(n, size); }
void *realloc(void *old, size_t size) { return NONE(size) ? NULL : __libc_realloc(old, size); }
void *aligned_alloc(size_t by, size_t size) { return NONE(size) ? NULL : __libc_memalign(by, size); }
