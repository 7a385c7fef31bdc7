/* Preloaded into a process by faults.py: counts its operations on the files of one folder, makes
   the n-th of them fail or sends a signal there, and keeps a record of all for a replay. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { OPEN = 1, WRITE = 2, FSYNC = 4, RENAME = 8, MKDIR = 16, UNLINK = 32, TRUNCATE = 64, MEMORY = 128 };
enum { FILES = 4096, LARGE = 2048 };

static char folder[PATH_MAX];
static int kinds, failure, sent, record = -1, armed, fired;
static long point = -1, seen, outside;
static int serial_of[FILES], serials;

void faults_arm(const char *below, int what, long n, int error, int signal_number, const char *log) {
    snprintf(folder, sizeof folder, "%s", below);
    kinds = what, point = n, failure = error, sent = signal_number, seen = outside = fired = 0;
    record = log[0] ? syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    memset(serial_of, 0, sizeof serial_of);
    armed = 1;
}
void faults_disarm(void) { armed = 0; }
long faults_seen(void) { return seen; }
long faults_outside(void) { return outside; }
int faults_fired(void) { return fired; }

static int fails(int kind) {
    if (!armed || !(kinds & kind) || seen++ != point) return 0;
    fired = 1;
    if (sent) {
        kill(getpid(), sent);
        return 0;
    }
    errno = failure;
    return 1;
}

static void note(int kind, int serial, int64_t a, const char *one, const void *two, size_t size) {
    if (!armed || record < 0) return;
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
    if (changes && strncmp(whole, "/dev/", 5) && strncmp(whole, "/proc/", 6)) outside++;
    return 0;
}

static int opened(int at, const char *path, int flags, mode_t mode) {
    char whole[PATH_MAX];
    int changes = (flags & (O_WRONLY | O_RDWR | O_CREAT | O_TRUNC)) != 0;
    int mine = inside(at, path, whole, changes);
    if (mine && fails(OPEN)) return -1;
    int file = syscall(SYS_openat, at, path, flags, mode);
    if (file >= 0 && file < FILES) {
        serial_of[file] = mine ? ++serials : 0;
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
    if (file >= 0 && file < FILES) serial_of[file] = 0;
    return syscall(SYS_close, file);
}
ssize_t write(int file, const void *data, size_t size) {
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

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
static int no_memory(size_t size) { return armed && size >= LARGE && fails(MEMORY); }
void *malloc(size_t size) { return no_memory(size) ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return no_memory(n * size) ? NULL : __libc_calloc(n, size); }
void *realloc(void *old, size_t size) { return no_memory(size) ? NULL : __libc_realloc(old, size); }
void *aligned_alloc(size_t by, size_t size) { return no_memory(size) ? NULL : __libc_memalign(by, size); }
