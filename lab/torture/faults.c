/* Lets the k-th change that a process makes beneath one folder fail, or be its last: `fault_arm` says which.

   Preloaded, it stands before libc in every process, so it sees what Python, torch and Rerun write alike. A change is
   opening a file to write, a write, a sync, a renaming, a removal, a new folder. They are counted in memory that a
   process shares with its children: k is the number of a change, whoever makes it.  */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum { NONE, FULL, BROKEN, KILLED, TORN }; /* no space from here on; one I/O error; killed before; killed half-way */

static char root[4096];
static long at = -1;
static int kind = NONE;
static volatile long *count; /* of changes so far */

void fault_arm(const char *folder, long which, int what) {
    if (!count) count = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    *count = 0;
    at = which;
    kind = what;
    snprintf(root, sizeof root, "%s", folder);
}

long fault_count(void) { return count ? *count : 0; }

static int beneath(const char *path) {
    char whole[8192];
    if (!root[0]) return 0;
    if (path[0] != '/') {
        char here[4096];
        if (!getcwd(here, sizeof here)) return 0;
        snprintf(whole, sizeof whole, "%s/%s", here, path);
        path = whole;
    }
    size_t length = strlen(root);
    return !strncmp(path, root, length) && (path[length] == '/' || path[length] == 0);
}

static int open_beneath(int fd) {
    char link[64], path[4096];
    if (!root[0]) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return beneath(path);
}

static void end(void) {
    kill(getpid(), SIGKILL);
    for (;;) pause();
}

/* Count a change; return 0, or the error that it meets. A torn one dies in `torn`, after its first half. */
static int meet(int *torn) {
    long number = __sync_fetch_and_add(count, 1);
    if (number < at || (number > at && kind != FULL)) return 0;
    if (kind == FULL) return ENOSPC;
    if (kind == BROKEN) return EIO;
    if (kind == TORN && torn) return *torn = 1, 0;
    if (kind == KILLED || kind == TORN) end();
    return 0;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int fd, const void *data, size_t size) {
    int torn = 0, error = open_beneath(fd) ? meet(&torn) : 0;
    if (error) return errno = error, -1;
    if (torn) {
        REAL(write)(fd, data, size / 2);
        end();
    }
    return REAL(write)(fd, data, size);
}

ssize_t pwrite64(int fd, const void *data, size_t size, off64_t offset) {
    int error = open_beneath(fd) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(pwrite64)(fd, data, size, offset);
}

ssize_t writev(int fd, const struct iovec *parts, int number) {
    int error = open_beneath(fd) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(writev)(fd, parts, number);
}

int fsync(int fd) {
    int error = open_beneath(fd) ? meet(NULL) : 0;
    if (error == ENOSPC) error = 0; /* nothing new is written */
    return error ? (errno = error, -1) : REAL(fsync)(fd);
}

int ftruncate64(int fd, off64_t size) {
    int error = open_beneath(fd) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(ftruncate64)(fd, size);
}

#define OPENED(name, before, given, call)                                  \
    int name(before const char *path, int flags, ...) {                    \
        mode_t mode = 0;                                                   \
        if (flags & (O_CREAT | __O_TMPFILE)) {                             \
            va_list more;                                                  \
            va_start(more, flags);                                         \
            mode = va_arg(more, mode_t);                                   \
            va_end(more);                                                  \
        }                                                                  \
        int error = (flags & O_ACCMODE) != O_RDONLY && beneath(path) ? meet(NULL) : 0; \
        return error ? (errno = error, -1) : REAL(name) call;              \
    }
#define COMMA ,
OPENED(open, , , (path, flags, mode))
OPENED(open64, , , (path, flags, mode))
OPENED(openat, int folder COMMA, , (folder, path, flags, mode))
OPENED(openat64, int folder COMMA, , (folder, path, flags, mode))

FILE *fopen64(const char *path, const char *mode) {
    int error = mode[0] != 'r' && beneath(path) ? meet(NULL) : 0;
    return error ? (errno = error, NULL) : REAL(fopen64)(path, mode);
}

FILE *fopen(const char *path, const char *mode) {
    int error = mode[0] != 'r' && beneath(path) ? meet(NULL) : 0;
    return error ? (errno = error, NULL) : REAL(fopen)(path, mode);
}

int rename(const char *old, const char *new) {
    int error = beneath(new) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(rename)(old, new);
}

int renameat(int from, const char *old, int to, const char *new) {
    int error = beneath(new) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(renameat)(from, old, to, new);
}

int unlink(const char *path) {
    int error = beneath(path) ? meet(NULL) : 0;
    if (error == ENOSPC) error = 0; /* it frees space */
    return error ? (errno = error, -1) : REAL(unlink)(path);
}

int mkdir(const char *path, mode_t mode) {
    int error = beneath(path) ? meet(NULL) : 0;
    return error ? (errno = error, -1) : REAL(mkdir)(path, mode);
}
