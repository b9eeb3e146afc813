/* Record which functions of a compiled ROS node issue its commands.
 *
 *     cc -O2 -fPIC -shared -fexceptions -o libtracerisk_calls.so calls.c -ldl -lgcc_s
 *     LD_PRELOAD=$PWD/libtracerisk_calls.so TRACERISK_CALLS=calls.jsonl ./node
 *
 * It stands before the functions through which every message, goal and service call of roscpp and
 * of rcl passes. It stores addresses alone; `tracerisk` names the functions afterwards.
 * docs/probe.md describes the file.
 *
 * The file is written through shared memory: a record is in it as soon as it is made, whatever then
 * ends the process. No system call is made but when a piece of the file is full. Whatever goes
 * wrong, the node goes on.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#include <unwind.h>

#define EXPORT __attribute__((visibility("default")))
#define LOCAL __thread __attribute__((tls_model("initial-exec")))

enum {
  PIECE = 1 << 16, /* bytes of the file that a process takes at a time */
  DEEPEST = 256,   /* functions of any binary on a stack; those further out are not recorded */
  MOST_MODULES = 256,
  BUCKETS = 256,
};

/* ---- What is known of this process. `lock` guards everything below it. ---- */

static char file[PATH_MAX]; /* where to write; empty: nowhere */
static volatile sig_atomic_t is_on;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static LOCAL bool is_recording; /* a signal's handler that publishes would wait for itself */
static LOCAL int tid;
static int pid;
static bool has_begun; /* this process has told of itself */

static char *piece;        /* the piece of the file in memory */
static size_t room, taken; /* its bytes, and those of them that are in use */
static volatile sig_atomic_t is_piece_gone;
static struct sigaction after_us; /* what SIGBUS did before */

struct module {
  uintptr_t begin, end;
};
static struct module modules[MOST_MODULES]; /* the node's own binaries */
static int module_count, map_number;
static unsigned long long loads = ~0ULL, unloads; /* of binaries, when `modules` was made */

struct counter {
  struct counter *next;
  const char *kind;
  const void *end;     /* the publisher of ROS 2 that is counted; NULL: all of a name together */
  uint64_t end_number; /* its number among those of this process; 0 for NULL */
  uint64_t count;
  size_t length; /* of the name */
  size_t written_length;
  char *written; /* the name as a string of JSON, in its quotes */
  char name[];
};
static struct counter *counters[BUCKETS];
static uint64_t ends_counted;

/* ---- Trouble: said once, and the node goes on. ---- */

struct quiet {
  sigset_t asked, before, waiting;
};

/* Neither a full pipe behind stderr nor a limit of file sizes may end the node. */
static void begin_quiet(struct quiet *quiet)
{
  sigemptyset(&quiet->asked);
  sigaddset(&quiet->asked, SIGPIPE);
  sigaddset(&quiet->asked, SIGXFSZ);
  sigpending(&quiet->waiting);
  pthread_sigmask(SIG_BLOCK, &quiet->asked, &quiet->before);
}

static void end_quiet(struct quiet *quiet)
{
  const struct timespec now = {0, 0};
  sigset_t ours = quiet->asked;
  if (sigismember(&quiet->waiting, SIGPIPE)) sigdelset(&ours, SIGPIPE);
  if (sigismember(&quiet->waiting, SIGXFSZ)) sigdelset(&ours, SIGXFSZ);
  while (sigtimedwait(&ours, NULL, &now) > 0 || errno == EINTR) errno = 0;
  pthread_sigmask(SIG_SETMASK, &quiet->before, NULL);
}

static void give_up(const char *problem, int error)
{
  struct quiet quiet;
  if (!is_on) return;
  is_on = 0;
  begin_quiet(&quiet);
  dprintf(STDERR_FILENO, "tracerisk: %s: %s%s%s; no further command of process %d is recorded\n",
          file, problem, error ? ": " : "", error ? strerror(error) : "", (int)getpid());
  end_quiet(&quiet);
}

/* A piece of a file that someone else cut off is no memory any more. */
static void on_bus_error(int number, siginfo_t *info, void *context)
{
  char *at = info->si_addr;
  (void)context;
  if (piece && at >= piece && at < piece + room) {
    is_piece_gone = 1;
    if (mmap(piece, room, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) !=
        MAP_FAILED)
      return;
  }
  sigaction(number, &after_us, NULL); /* the same instruction fails again, and is handled there */
}

static void guard_piece(void)
{
  struct sigaction ours = {.sa_sigaction = on_bus_error, .sa_flags = SA_SIGINFO | SA_ONSTACK}, now;
  if (piece || sigaction(SIGBUS, NULL, &now) || now.sa_sigaction == on_bus_error) return;
  sigemptyset(&ours.sa_mask);
  after_us = now;
  sigaction(SIGBUS, &ours, NULL);
}

static void leave_piece(void)
{
  if (piece) munmap(piece, room);
}

/* ---- The file ---- */

/* Append a piece to the file; return where it begins, -1 and `error` if that fails. */
static off_t append_piece(int to, int *error)
{
  static const char nothing[PIECE];
  struct quiet quiet;
  begin_quiet(&quiet);
  /* The space is there before it is used: a full disk fails here, where it does no harm. Appending
   * is one step for the kernel, so that no process takes the piece of another. */
  ssize_t length = write(to, nothing, PIECE);
  *error = length < 0 ? errno : ENOSPC;
  off_t end = length == PIECE ? lseek(to, 0, SEEK_CUR) : -1;
  end_quiet(&quiet);
  return end < 0 ? -1 : end - PIECE;
}

/* Take the next piece of the file. */
static bool take_piece(void)
{
  const off_t page = sysconf(_SC_PAGESIZE);
  struct stat there;
  int error = 0;
  int to = open(file, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK, 0666);
  if (to < 0) {
    give_up("cannot be opened", errno);
    return false;
  }
  if (fstat(to, &there) || !S_ISREG(there.st_mode)) {
    close(to);
    give_up("is no regular file", 0);
    return false;
  }
  off_t from = append_piece(to, &error);
  if (from < 0) {
    close(to);
    give_up("cannot grow", error);
    return false;
  }
  off_t aligned = (from + page - 1) / page * page; /* if others have written to the file */
  size_t size = (size_t)(from + PIECE - aligned);
  char *next = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, to, aligned);
  error = errno;
  close(to);
  if (next == MAP_FAILED) {
    give_up("cannot be mapped", error);
    return false;
  }
  guard_piece();
  leave_piece();
  piece = next;
  room = size;
  piece[0] = '\n'; /* ends the line of a process that was killed while it wrote */
  taken = 1;
  return true;
}

/* Return where `most` bytes can be written; NULL if nowhere. */
static char *space(size_t most)
{
  if ((!piece || taken + most > room) && !take_piece()) return NULL;
  if (taken + most > room) return NULL; /* a name of many thousand letters */
  return piece + taken;
}

static void wrote(const char *end)
{
  taken = (size_t)(end - piece);
  if (is_piece_gone) give_up("was cut off by another program", 0);
}

/* Write a line that is made already; return whether there was space for it. */
static bool put_line(const char *line, size_t length)
{
  char *to = space(length);
  if (!to) return false;
  memcpy(to, line, length);
  wrote(to + length);
  return true;
}

static char *put(char *to, const char *text)
{
  size_t length = strlen(text);
  memcpy(to, text, length);
  return to + length;
}

static char *put_number(char *to, uint64_t number)
{
  char digits[20];
  int at = 20;
  do digits[--at] = (char)('0' + number % 10);
  while (number /= 10);
  memcpy(to, digits + at, 20 - at);
  return to + 20 - at;
}

/* Write a string of JSON; at most 6 bytes for one, and two quotes. */
static char *put_string(char *to, const char *text, size_t length)
{
  static const char hex[] = "0123456789abcdef";
  *to++ = '"';
  for (size_t at = 0; at < length; ++at) {
    unsigned char sign = (unsigned char)text[at];
    if (sign == '"' || sign == '\\') {
      *to++ = '\\';
      *to++ = (char)sign;
    } else if (sign < ' ') {
      to = put(to, "\\u00");
      *to++ = hex[sign >> 4];
      *to++ = hex[sign & 15];
    } else {
      *to++ = (char)sign;
    }
  }
  *to++ = '"';
  return to;
}

/* ---- The node's own binaries ---- */

/* A workspace may have built ROS 2 itself. */
static bool is_of_ros2(const char *path)
{
  static const char *const names[] = {"librcl.so",          "librcl_action.so",
                                      "librcl_lifecycle.so", "librclcpp.so",
                                      "librclcpp_action.so", "librclcpp_lifecycle.so",
                                      "librcutils.so",       "librcpputils.so"};
  const char *slash = strrchr(path, '/');
  for (size_t at = 0; at < sizeof names / sizeof *names; ++at)
    if (slash && !strcmp(slash + 1, names[at])) return true;
  return false;
}

static bool is_installed(const char *path)
{
  static const char *const places[] = {"/usr/", "/lib", "/bin/", "/sbin/", "/opt/ros/"};
  for (size_t at = 0; at < sizeof places / sizeof *places; ++at)
    if (!strncmp(path, places[at], strlen(places[at]))) return true;
  return path[0] != '/' || is_of_ros2(path); /* such as linux-vdso.so.1 */
}

static int note_loads(struct dl_phdr_info *info, size_t size, void *now)
{
  (void)size;
  ((unsigned long long *)now)[0] = info->dlpi_adds;
  ((unsigned long long *)now)[1] = info->dlpi_subs;
  return 1; /* the first binary tells it */
}

struct listing {
  char *text; /* NULL after a failure */
  size_t size;
  FILE *to;
};

static int list_module(struct dl_phdr_info *info, size_t size, void *given)
{
  struct listing *listing = given;
  char path[PATH_MAX], quoted[6 * PATH_MAX + 2];
  uintptr_t begin = UINTPTR_MAX, end = 0, here = (uintptr_t)list_module;
  struct stat there;
  (void)size;
  if (!realpath(info->dlpi_name[0] ? info->dlpi_name : "/proc/self/exe", path)) return 0;
  for (int at = 0; at < info->dlpi_phnum; ++at) {
    const ElfW(Phdr) *part = &info->dlpi_phdr[at];
    if (part->p_type != PT_LOAD || !(part->p_flags & PF_X)) continue;
    uintptr_t from = info->dlpi_addr + part->p_vaddr;
    if (from < begin) begin = from;
    if (from + part->p_memsz > end) end = from + part->p_memsz;
  }
  if (end == 0 || (here >= begin && here < end) || is_installed(path)) return 0;
  if (module_count == MOST_MODULES || stat(path, &there)) return 0;
  modules[module_count++] = (struct module){begin, end};
  *put_string(quoted, path, strlen(path)) = '\0';
  fprintf(listing->to, "%s[%s,%llu,%llu,%llu,%llu,%llu]", module_count > 1 ? "," : "", quoted,
          (unsigned long long)info->dlpi_addr, (unsigned long long)begin, (unsigned long long)end,
          (unsigned long long)there.st_size,
          there.st_mtim.tv_sec * 1000000000ULL + (unsigned long long)there.st_mtim.tv_nsec);
  return 0;
}

/* Write the list of binaries, if it has changed. */
static void list_modules(void)
{
  unsigned long long now[2] = {0, 0};
  dl_iterate_phdr(note_loads, now);
  if (now[0] == loads && now[1] == unloads) return;
  struct listing listing = {NULL, 0, NULL};
  listing.to = open_memstream(&listing.text, &listing.size);
  if (!listing.to) return;
  loads = now[0], unloads = now[1];
  module_count = 0;
  fprintf(listing.to, "{\"pid\":%d,\"map\":%d,\"modules\":[", pid, ++map_number);
  dl_iterate_phdr(list_module, &listing);
  fputs("]}\n", listing.to);
  if (fclose(listing.to) == 0 && !put_line(listing.text, listing.size))
    give_up("has no room for the list of binaries", 0);
  free(listing.text);
}

/* ---- A record ---- */

static void begin_process(bool is_forked)
{
  char path[PATH_MAX], line[6 * PATH_MAX + 64];
  ssize_t length = readlink("/proc/self/exe", path, sizeof path);
  pid = (int)getpid();
  has_begun = true;
  loads = ~0ULL;
  map_number = 0;
  char *to = put_number(put(line, "{\"probe\":1,\"pid\":"), (uint64_t)pid);
  to = put_string(put(to, ",\"exe\":"), path, length < 0 ? 0 : (size_t)length);
  to = put(to, is_forked ? ",\"forked\":1}\n" : "}\n");
  put_line(line, (size_t)(to - line));
}

/* Record something of the process itself: a key, quoted, and a number; `lock` is held. */
static void put_of_process(const char *key, unsigned number)
{
  char line[64];
  char *to = put(put_number(put(line, "{\"pid\":"), (uint64_t)pid), ",");
  to = put(put_number(put(to, key), number), "}\n");
  put_line(line, (size_t)(to - line));
}

#ifdef __GLIBC__
/* Record the code with which the process ends; one that a signal ends has none. */
static void note_exit(int code, void *nothing)
{
  (void)nothing;
  if (!is_on || !has_begun || is_recording) return;
  is_recording = true;
  pthread_mutex_lock(&lock);
  put_of_process("\"exit\":", code & 255);
  pthread_mutex_unlock(&lock);
  is_recording = false;
}
#endif

/* ---- Whether nothing is in progress: all that is expected is what comes from elsewhere. ---- */

static bool tells_waits; /* a live run asks; on a robot nobody does, and callbacks come often */
static int calling_back; /* threads that are in a callback */
static int spinning;     /* whether the main thread waits for callbacks alone, or for the end */
static unsigned told_callbacks, told_spins;
static LOCAL bool is_spinning; /* `spinning`, of this thread */
static LOCAL int works;        /* callbacks and waits of this thread, one within the other */
static LOCAL bool takes_time;  /* a thread of ROS itself, for each time that comes */

static void tell_state(void)
{
  if (!is_on || !has_begun || is_recording) return;
  int error = errno;
  is_recording = true;
  pthread_mutex_lock(&lock);
  unsigned calls_back = __atomic_load_n(&calling_back, __ATOMIC_SEQ_CST) > 0;
  unsigned spins = __atomic_load_n(&spinning, __ATOMIC_SEQ_CST) > 0;
  if (calls_back != told_callbacks) put_of_process("\"calls_back\":", calls_back);
  if (spins != told_spins) put_of_process("\"spins\":", spins);
  told_callbacks = calls_back, told_spins = spins;
  pthread_mutex_unlock(&lock);
  is_recording = false;
  errno = error;
}

/* They take what ends with the function that calls them, even if it throws: see `cleanup`. */

static bool begin_callback(void)
{
  if (!tells_waits || takes_time) return false;
  if (!works++ && __atomic_add_fetch(&calling_back, 1, __ATOMIC_SEQ_CST) == 1) tell_state();
  return true;
}

static void end_callback(const bool *has_begun_it)
{
  if (*has_begun_it && !--works && !__atomic_sub_fetch(&calling_back, 1, __ATOMIC_SEQ_CST))
    tell_state();
}

static bool begin_spin(void)
{
  if (!tells_waits || is_spinning || syscall(SYS_gettid) != getpid()) return false;
  __atomic_store_n(&spinning, is_spinning = true, __ATOMIC_SEQ_CST);
  tell_state();
  return true;
}

static void end_spin(const bool *has_begun_it)
{
  if (!*has_begun_it) return;
  __atomic_store_n(&spinning, is_spinning = false, __ATOMIC_SEQ_CST);
  tell_state();
}

static bool tell_wait(bool begins, const void *caller);

/* Of a wait that ends by itself it is told where, for a loop may come back to it for ever; what a
 * spin or a callback waits is none. One on a condition counts where the node's own code waits. */
static bool begin_wait(const void *caller)
{
  if (!tells_waits || is_spinning || works || !is_on || !has_begun || is_recording) return false;
  works = tell_wait(true, caller);
  return works;
}

static void end_wait(const bool *has_begun_it)
{
  if (!*has_begun_it) return;
  works = 0;
  tell_wait(false, NULL);
}

#define WHILE(begins, end) __attribute__((cleanup(end))) const bool during = begins; (void)during
#define CALLING_BACK WHILE(begin_callback(), end_callback)
#define WAITING WHILE(begin_wait(NULL), end_wait)
#define WAITING_BY_OWN_CODE WHILE(begin_wait(__builtin_return_address(0)), end_wait)
#define SPINNING WHILE(begin_spin(), end_spin)

struct stack {
  uintptr_t at[DEEPEST];
  int depth;
  bool is_cut;
};

static _Unwind_Reason_Code note_frame(struct _Unwind_Context *context, void *given)
{
  struct stack *stack = given;
  int is_before = 0;
  uintptr_t at = _Unwind_GetIPInfo(context, &is_before);
  if (!at) return _URC_END_OF_STACK;
  if (stack->depth == DEEPEST) {
    stack->is_cut = true;
    return _URC_END_OF_STACK;
  }
  stack->at[stack->depth++] = at + (is_before ? 1 : 0); /* as if each were a return address */
  return _URC_NO_REASON;
}

static struct counter *counter_of(const char *kind, const char *name, size_t length, const void *of)
{
  size_t hash = 5381;
  for (size_t at = 0; at < length; ++at) hash = hash * 33 + (unsigned char)name[at];
  struct counter **there = &counters[hash % BUCKETS];
  for (struct counter *known = *there; known; known = known->next)
    if (known->kind == kind && known->end == of && known->length == length &&
        !memcmp(known->name, name, length))
      return known;
  struct counter *made = calloc(1, sizeof *made + length + 6 * length + 2);
  if (!made) return NULL;
  made->kind = kind;
  made->end = of;
  made->end_number = of ? ++ends_counted : 0;
  made->length = length;
  memcpy(made->name, name, length);
  made->written = made->name + length;
  made->written_length = (size_t)(put_string(made->written, name, length) - made->written);
  made->next = *there;
  *there = made;
  return made;
}

/* Count no more for what is gone: another may come to lie where it was. */
static void forget_end(const void *gone)
{
  static const char nobody;
  for (int at = 0; at < BUCKETS; ++at)
    for (struct counter *known = counters[at]; known; known = known->next)
      if (known->end == gone) known->end = &nobody;
}

/* Whether what returns to an address is in the node's own binaries. */
static bool is_own(uintptr_t address)
{
  for (int at = 0; at < module_count; ++at)
    if (address - 1 - modules[at].begin < modules[at].end - modules[at].begin) return true;
  return false;
}

/* Write the node's own part of a stack, and the end of the line. */
static char *put_stack(char *to, const struct stack *stack)
{
  to = put(put_number(put(to, ",\"map\":"), (uint64_t)map_number), ",\"at\":[");
  const char *first = to;
  for (int frame = 0; frame < stack->depth; ++frame) {
    if (!is_own(stack->at[frame])) continue;
    if (to != first) *to++ = ',';
    to = put_number(to, stack->at[frame]);
  }
  return put(to, stack->is_cut ? "],\"cut\":1}\n" : "]}\n");
}

/* What is recorded: a command, or with the number of a call its end. */
struct command {
  const char *kind, *name;
  size_t length;          /* of the name */
  const void *end;        /* the publisher of ROS 2 */
  const uint64_t *number; /* of the call that ends */
};

/* Write a record; return its number among those of its kind, name and publisher. */
static uint64_t write_record(const struct command *command, const struct stack *stack)
{
  struct timespec now;
  if (!has_begun) begin_process(false);
  list_modules();
  struct counter *counter =
      is_on ? counter_of(command->kind, command->name, command->length, command->end) : NULL;
  if (!counter) return 0;
  uint64_t seq = command->number ? *command->number : counter->count++;
  char *to = space(256 + counter->written_length + 21 * (size_t)stack->depth);
  if (!to) return seq;
  clock_gettime(CLOCK_MONOTONIC, &now);
  to = put_number(put(to, "{\"t\":"), now.tv_sec * 1000000000ULL + (uint64_t)now.tv_nsec);
  to = put_number(put(to, ",\"pid\":"), (uint64_t)pid);
  to = put_number(put(to, ",\"tid\":"), (uint64_t)tid);
  to = put(put(put(to, ",\"kind\":\""), command->kind), "\",\"name\":");
  memcpy(to, counter->written, counter->written_length);
  to = put_number(put(to + counter->written_length, ",\"seq\":"), seq);
  if (counter->end_number) to = put_number(put(to, ",\"of\":"), counter->end_number);
  wrote(put_stack(to, stack));
  return seq;
}

static uint64_t record(const struct command *command)
{
  if (!is_on || is_recording || !command->name) return 0;
  int error = errno;
  struct stack stack = {.depth = 0, .is_cut = false};
  is_recording = true;
  if (!tid) tid = (int)syscall(SYS_gettid);
  if (!command->number) _Unwind_Backtrace(note_frame, &stack);
  pthread_mutex_lock(&lock);
  uint64_t seq = write_record(command, &stack);
  pthread_mutex_unlock(&lock);
  is_recording = false;
  errno = error;
  return seq;
}

static const char wait[] = "wait", waited[] = "waited";

/* Record that this thread begins a wait, or that it is over; return whether it did. */
static bool tell_wait(bool begins, const void *caller)
{
  static const uint64_t none = 0;
  if (!is_on || is_recording) return false;
  int error = errno;
  struct stack stack = {.depth = 0, .is_cut = false};
  is_recording = true;
  if (!tid) tid = (int)syscall(SYS_gettid);
  pthread_mutex_lock(&lock);
  list_modules();
  if (begins && (!caller || is_own((uintptr_t)caller))) _Unwind_Backtrace(note_frame, &stack);
  bool counts = !begins;
  for (int frame = 0; frame < stack.depth && !counts; ++frame) counts = is_own(stack.at[frame]);
  if (counts)
    write_record(&(struct command){begins ? wait : waited, "", 0, NULL, begins ? NULL : &none},
                 &stack);
  pthread_mutex_unlock(&lock);
  is_recording = false;
  errno = error;
  return counts;
}

static const char publish[] = "publish", goal[] = "goal", call[] = "call", end[] = "end";

/* Record what an end of ROS 2 sends; messages are counted for each publisher. */
static void record_of(const char *kind, const char *name, const void *publisher)
{
  record(&(struct command){kind, name, name ? strlen(name) : 0, publisher, NULL});
}

/* The end of a call is recorded even if it throws, or its thread is cancelled. */
struct called {
  const char *name;
  size_t length;
  uint64_t seq;
};

static void record_end(struct called *called)
{
  record(&(struct command){end, called->name, called->length, NULL, &called->seq});
}

/* ---- Beginning of the process ---- */

static void after_fork(void)
{
  pthread_mutex_init(&lock, NULL);
  leave_piece(); /* it is the parent's */
  piece = NULL;
  tid = 0;
  is_recording = false;
  spinning = is_spinning;
  calling_back = works > 0;
  told_spins = told_callbacks = 0;
  for (int at = 0; at < BUCKETS; ++at)
    for (struct counter *known = counters[at]; known; known = known->next) known->count = 0;
  bool is_node = has_begun;
  has_begun = false;
  if (is_on && is_node) begin_process(true);
}

/* Return a function that stands behind one of ours. */
static void *behind(const char *name)
{
  static const char *const libraries[] = {"libroscpp.so", "librcl.so", "librcl_action.so",
                                          "librcutils.so", "librostime.so", "librclcpp.so"};
  void *found = NULL;
#ifdef __GLIBC__
  /* Of several versions of a function, RTLD_NEXT finds the oldest before glibc 2.36 (its bug 14932):
     of the waits for a condition, that for a condition of another layout. */
  found = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2");
#endif
  if (!found) found = dlsym(RTLD_NEXT, name);
  for (size_t at = 0; !found && at < sizeof libraries / sizeof *libraries; ++at) {
    /* An extension of Python loads it for itself alone. */
    void *library = dlopen(libraries[at], RTLD_LAZY | RTLD_NOLOAD);
    if (!library) continue;
    found = dlsym(library, name);
    dlclose(library);
  }
  return found;
}

static void *found(void **known, const char *name)
{
  void *function = __atomic_load_n(known, __ATOMIC_ACQUIRE);
  if (!function) {
    function = behind(name);
    if (!function) dprintf(STDERR_FILENO, "tracerisk: no library of this node has %s\n", name);
    __atomic_store_n(known, function, __ATOMIC_RELEASE);
  }
  return function;
}

/* The function of that name in the library of ROS; each is looked up once. */
#define BEHIND(function)                                      \
  ({                                                          \
    static void *known;                                       \
    (__typeof__(&(function)))found(&known, TEXT(function));   \
  })
#define TEXT(name) TEXT_OF(name)
#define TEXT_OF(name) #name

#define ROS1_PUBLISH \
  _ZNK3ros9Publisher7publishERKN5boost8functionIFNS_17SerializedMessageEvEEERS3_
#define ROS1_START _ZN3ros5startEv
#define ROS1_SPIN_ONE _ZN3ros21SingleThreadedSpinner4spinEPNS_13CallbackQueueE
#define ROS1_SPIN_MANY _ZN3ros20MultiThreadedSpinner4spinEPNS_13CallbackQueueE
#define ROS1_AWAIT_END _ZN3ros15waitForShutdownEv
#define ROS1_TAKE_TIME _ZN3ros10spinThreadEv
#define ROS1_CALL_BACK _ZN3ros13CallbackQueue9callOneCBEPNS0_3TLSE
#define ROS1_SLEEP _ZNK3ros8Duration5sleepEv
#define ROS1_SLEEP_UNTIL _ZN3ros4Time10sleepUntilERKS0_
#define ROS1_AWAIT_TIME _ZN3ros4Time12waitForValidERKNS_12WallDurationE
#define ROS1_CALL                                                                            \
  _ZN3ros13ServiceClient4callERKNS_17SerializedMessageERS1_RKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE

/* A live run says when its time begins [ns since 1970]. A node on a robot has a time at once, and
 * shall not take the first of the clock for a jump. */

static int64_t beginning(void)
{
  const char *given = getenv("TRACERISK_TIME_BEGINS");
  return given ? strtoll(given, NULL, 10) : 0;
}

__attribute__((constructor)) static void begin(void)
{
  const char *named = getenv("TRACERISK_CALLS");
  if (!named || !*named) return;
  if (named[0] != '/' && getcwd(file, sizeof file - 1)) strcat(file, "/");
  if (strlen(file) + strlen(named) >= sizeof file) {
    dprintf(STDERR_FILENO, "tracerisk: TRACERISK_CALLS is longer than a path can be\n");
    return;
  }
  strcat(file, named);
  is_on = 1;
  tells_waits = beginning() != 0;
  pthread_atfork(NULL, NULL, after_fork);
#ifdef __GLIBC__
  on_exit(note_exit, NULL);
#endif
  /* Shells and other programs that start the node have nothing to report. */
  if (behind(TEXT(ROS1_PUBLISH)) || behind("rcl_publish")) begin_process(false);
}

/* ---- ROS 1: roscpp. Both classes hold one pointer, to what the public headers say. ---- */

struct std_string {
  const char *text;
  size_t length;
  char within[16];
};

struct publisher {
  struct std_string topic, md5sum, datatype;
};

struct service_client {
  void *link[2];
  struct std_string name;
};

static bool ends_with(const struct std_string *text, const char *ending)
{
  size_t length = strlen(ending);
  return text->length >= length && !memcmp(text->text + text->length - length, ending, length);
}

struct wall_duration {
  int32_t seconds, nanoseconds;
};

bool ROS1_AWAIT_TIME(const struct wall_duration *most); /* never linked */

EXPORT void ROS1_START(void)
{
  BEHIND(ROS1_START)();
  if (beginning()) BEHIND(ROS1_AWAIT_TIME)(&(struct wall_duration){10, 0});
}

EXPORT void ROS1_SPIN_ONE(void *self, void *queue)
{
  SPINNING;
  BEHIND(ROS1_SPIN_ONE)(self, queue);
}

EXPORT void ROS1_SPIN_MANY(void *self, void *queue)
{
  SPINNING;
  BEHIND(ROS1_SPIN_MANY)(self, queue);
}

EXPORT void ROS1_AWAIT_END(void)
{
  SPINNING;
  BEHIND(ROS1_AWAIT_END)();
}

EXPORT void ROS1_TAKE_TIME(void)
{
  takes_time = true;
  BEHIND(ROS1_TAKE_TIME)();
}

EXPORT int ROS1_CALL_BACK(void *self, void *called)
{
  CALLING_BACK;
  return BEHIND(ROS1_CALL_BACK)(self, called);
}

EXPORT bool ROS1_SLEEP(const void *self)
{
  WAITING;
  return BEHIND(ROS1_SLEEP)(self);
}

EXPORT bool ROS1_SLEEP_UNTIL(const void *end)
{
  WAITING;
  return BEHIND(ROS1_SLEEP_UNTIL)(end);
}

EXPORT void ROS1_PUBLISH(const struct publisher *const *self, const void *serialize, void *message)
{
  const struct publisher *to = *self;
  if (to && ends_with(&to->topic, "/goal") && ends_with(&to->datatype, "ActionGoal"))
    record(&(struct command){goal, to->topic.text, to->topic.length - strlen("/goal"), NULL, NULL});
  else if (to)
    record(&(struct command){publish, to->topic.text, to->topic.length, NULL, NULL});
  BEHIND(ROS1_PUBLISH)(self, serialize, message);
}

EXPORT bool ROS1_CALL(const struct service_client *const *self, const void *request, void *response,
                      const struct std_string *md5sum)
{
  const struct service_client *to = *self;
  if (!to) return BEHIND(ROS1_CALL)(self, request, response, md5sum);
  __attribute__((cleanup(record_end))) struct called called = {to->name.text, to->name.length, 0};
  called.seq = record(&(struct command){call, called.name, called.length, NULL, NULL});
  return BEHIND(ROS1_CALL)(self, request, response, md5sum);
}

/* ---- ROS 2: the C functions of rcl, which serve C++ and Python. ---- */

/* Never linked: only their types are used. */
const char *rcl_publisher_get_topic_name(const void *publisher);
const char *rcl_subscription_get_topic_name(const void *subscription);
const char *rcl_client_get_service_name(const void *client);
const char *rcl_service_get_service_name(const void *service);
const char *rcl_node_get_fully_qualified_name(const void *node);
void rcutils_reset_error(void);

#define NAME(of, self)                        \
  ({                                          \
    __typeof__(&(of)) name_of = BEHIND(of);   \
    name_of ? name_of(self) : NULL;           \
  })

/* The beginning of the structures of rosidl and rmw: the same since Foxy. */

struct type_support {
  const char *language;
  const void *members;
  const struct type_support *(*in)(const struct type_support *, const char *);
};

struct members {
  const char *space, *name;
};

struct qos {
  int history;
  size_t depth;
  int reliability, durability;
};

enum { BEST_EFFORT = 2, TRANSIENT_LOCAL = 1 };

/* Return how a type is called: not at all where its package was built without descriptions. */
static const struct members *members_of(const struct type_support *type)
{
  static const struct members unknown = {"", ""};
  size_t length = type && type->language ? strlen(type->language) : 0;
  bool is_cpp = length >= 4 && !strcmp(type->language + length - 4, "_cpp");
  const struct type_support *described = NULL;
  if (length && type->in)
    described = type->in(type, is_cpp ? "rosidl_typesupport_introspection_cpp"
                                      : "rosidl_typesupport_introspection_c");
  if (!described && BEHIND(rcutils_reset_error)) BEHIND(rcutils_reset_error)();
  return described ? described->members : &unknown;
}

struct end {
  const void *self;
  const char *what, *name, *node;
  const struct members *type; /* NULL of one that is gone */
  const struct qos *qos;      /* NULL of a service's */
};

/* Record that a node made an end of a topic or service, or that it is gone. */
static void record_end_of_name(const struct end *of)
{
  static const char none[] = "";
  if (!is_on || is_recording || !of->name || !of->node) return;
  const struct members unknown = {none, none}, *type = of->type ? of->type : &unknown;
  int error = errno;
  is_recording = true;
  pthread_mutex_lock(&lock);
  if (!has_begun) begin_process(false);
  if (!of->type) forget_end(of->self);
  size_t letters = strlen(of->name) + strlen(of->node) + strlen(type->space) + strlen(type->name);
  char *to = space(6 * letters + 256);
  if (to) {
    to = put_number(put(to, "{\"pid\":"), (uint64_t)pid);
    to = put(put(to, of->type ? ",\"made\":\"" : ",\"gone\":\""), of->what);
    to = put(to, "\",\"name\":");
    to = put_string(to, of->name, strlen(of->name));
    to = put_string(put(to, ",\"node\":"), of->node, strlen(of->node));
    if (of->type) {
      to = put_string(put(to, ",\"type\":["), type->space, strlen(type->space));
      to = put(put_string(put(to, ","), type->name, strlen(type->name)), "]");
    }
    if (of->qos) {
      to = put(to, of->qos->reliability == BEST_EFFORT ? ",\"reliable\":0" : ",\"reliable\":1");
      to = put(to, of->qos->durability == TRANSIENT_LOCAL ? ",\"kept\":1" : ",\"kept\":0");
    }
    wrote(put(to, "}\n"));
  }
  pthread_mutex_unlock(&lock);
  is_recording = false;
  errno = error;
}

/* An end of a name is made by rcl_KIND_init, and destroyed by rcl_KIND_fini. */
#define END_OF_NAME(kind, called, name_of, qos_of)                                              \
  EXPORT int rcl_##kind##_init(void *self, const void *node, const struct type_support *type,    \
                               const char *name, const void *options)                            \
  {                                                                                              \
    int failed = BEHIND(rcl_##kind##_init)(self, node, type, name, options);                     \
    if (is_on && !failed)                                                                        \
      record_end_of_name(&(struct end){self, called, NAME(name_of, self),                        \
                                       NAME(rcl_node_get_fully_qualified_name, node),            \
                                       members_of(type), qos_of});                               \
    return failed;                                                                               \
  }                                                                                              \
  EXPORT int rcl_##kind##_fini(void *self, void *node)                                           \
  {                                                                                              \
    record_end_of_name(&(struct end){self, called, is_on ? NAME(name_of, self) : NULL,           \
                                     is_on ? NAME(rcl_node_get_fully_qualified_name, node) : NULL, \
                                     NULL, NULL});                                               \
    return BEHIND(rcl_##kind##_fini)(self, node);                                                \
  }

END_OF_NAME(publisher, "publisher", rcl_publisher_get_topic_name, options)
END_OF_NAME(subscription, "subscription", rcl_subscription_get_topic_name, options)
END_OF_NAME(client, "client", rcl_client_get_service_name, NULL)
END_OF_NAME(service, "service", rcl_service_get_service_name, NULL)

/* A live run gives its nodes arguments of ROS, a word a line, and one domain. On a robot there are
 * none. */

static const char *given_arguments(void)
{
  const char *given = getenv("TRACERISK_ROS_ARGUMENTS");
  return given && *given ? given : NULL;
}

EXPORT int rcl_init(int argc, const char *const *argv, const void *options, void *context)
{
  const char *given = given_arguments();
  size_t had = argv && argc > 0 ? (size_t)argc : 0, count = had + 1;
  for (const char *at = given; at && *at; ++at) count += *at == '\n';
  char *text = given ? strdup(given) : NULL;
  const char **words = text ? calloc(count + 1, sizeof *words) : NULL;
  if (words) {
    if (had) memcpy(words, argv, had * sizeof *words);
    char *rest = text;
    while (rest && had < count) words[had++] = strsep(&rest, "\n");
  }
  int failed = words ? BEHIND(rcl_init)((int)had, words, options, context)
                     : BEHIND(rcl_init)(argc, argv, options, context);
  free(words);
  free(text);
  return failed;
}

EXPORT int rcl_set_ros_time_override(void *clock, int64_t time)
{
  return BEHIND(rcl_set_ros_time_override)(clock, time ? time : beginning());
}

EXPORT int rcl_init_options_set_domain_id(void *options, size_t domain)
{
  const size_t of_environment = SIZE_MAX;
  if (given_arguments()) domain = of_environment;
  return BEHIND(rcl_init_options_set_domain_id)(options, domain);
}

EXPORT int rcl_publish(const void *self, const void *message, void *allocation)
{
  record_of(publish, NAME(rcl_publisher_get_topic_name, self), self);
  return BEHIND(rcl_publish)(self, message, allocation);
}

EXPORT int rcl_publish_serialized_message(const void *self, const void *message, void *allocation)
{
  record_of(publish, NAME(rcl_publisher_get_topic_name, self), self);
  return BEHIND(rcl_publish_serialized_message)(self, message, allocation);
}

EXPORT int rcl_publish_loaned_message(const void *self, void *message, void *allocation)
{
  record_of(publish, NAME(rcl_publisher_get_topic_name, self), self);
  return BEHIND(rcl_publish_loaned_message)(self, message, allocation);
}

/* A goal passes here too, by a service whose name is resolved, unlike that of an action's client.
 * Asking for its result is no command. */
EXPORT int rcl_send_request(const void *self, const void *request, int64_t *number)
{
  static const char send_goal[] = "/_action/send_goal";
  const char *service = NAME(rcl_client_get_service_name, self);
  const char *of_action = service ? strstr(service, "/_action/") : NULL;
  if (of_action && !strcmp(of_action, send_goal))
    record(&(struct command){goal, service, (size_t)(of_action - service), NULL, NULL});
  else if (!of_action || strcmp(of_action, "/_action/get_result"))
    record_of(call, service, NULL);
  return BEHIND(rcl_send_request)(self, request, number);
}

/* ---- ROS 2: what rclcpp waits for. An executor that is not here calls back by other ways. ---- */

#define ROS2_SPIN_ONE _ZN6rclcpp9executors22SingleThreadedExecutor4spinEv
#define ROS2_SPIN_MANY _ZN6rclcpp9executors21MultiThreadedExecutor4spinEv
#define ROS2_CALL_BACK _ZN6rclcpp8Executor22execute_any_executableERNS_13AnyExecutableE
#define ROS2_TOPIC_OF _ZNK6rclcpp16SubscriptionBase14get_topic_nameEv
#define ROS2_SLEEP_UNTIL _ZN6rclcpp5Clock11sleep_untilENS_4TimeESt10shared_ptrINS_7ContextEE
#define ROS2_SLEEP \
  _ZN6rclcpp7Context9sleep_forERKNSt6chrono8durationIlSt5ratioILl1ELl1000000000EEEE

const char *ROS2_TOPIC_OF(const void *subscription); /* never linked */

EXPORT void ROS2_SPIN_ONE(void *self)
{
  SPINNING;
  BEHIND(ROS2_SPIN_ONE)(self);
}

EXPORT void ROS2_SPIN_MANY(void *self)
{
  SPINNING;
  BEHIND(ROS2_SPIN_MANY)(self);
}

/* The first pointer of rclcpp::AnyExecutable, behind that of its virtual functions, is NULL where
 * something else is ready; the same since Foxy. */
struct ready {
  const void *functions, *subscription;
};

/* Each node has a thread for the time, which comes often. */
static bool begin_what_is_ready(const struct ready *ready)
{
  if (!tells_waits) return false;
  const char *topic = ready->subscription ? NAME(ROS2_TOPIC_OF, ready->subscription) : NULL;
  return !(topic && !strcmp(topic, "/clock")) && begin_callback();
}

EXPORT void ROS2_CALL_BACK(void *self, const struct ready *ready)
{
  WHILE(begin_what_is_ready(ready), end_callback);
  BEHIND(ROS2_CALL_BACK)(self, ready);
}

EXPORT bool ROS2_SLEEP_UNTIL(void *self, const void *until, const void *context)
{
  WAITING;
  return BEHIND(ROS2_SLEEP_UNTIL)(self, until, context);
}

EXPORT bool ROS2_SLEEP(void *self, const int64_t *asked)
{
  WAITING;
  return BEHIND(ROS2_SLEEP)(self, asked);
}

/* ---- Waits on the wall clock ---- */

EXPORT int nanosleep(const struct timespec *asked, struct timespec *left)
{
  WAITING;
  return BEHIND(nanosleep)(asked, left);
}

EXPORT int clock_nanosleep(clockid_t of, int flags, const struct timespec *asked,
                           struct timespec *left)
{
  WAITING;
  return BEHIND(clock_nanosleep)(of, flags, asked, left);
}

EXPORT int usleep(useconds_t asked)
{
  WAITING;
  return BEHIND(usleep)(asked);
}

EXPORT unsigned sleep(unsigned asked)
{
  WAITING;
  return BEHIND(sleep)(asked);
}

EXPORT int pthread_cond_timedwait(pthread_cond_t *self, pthread_mutex_t *held,
                                  const struct timespec *until)
{
  WAITING_BY_OWN_CODE;
  return BEHIND(pthread_cond_timedwait)(self, held, until);
}

EXPORT int pthread_cond_clockwait(pthread_cond_t *self, pthread_mutex_t *held, clockid_t of,
                                  const struct timespec *until)
{
  WAITING_BY_OWN_CODE;
  return BEHIND(pthread_cond_clockwait)(self, held, of, until);
}

/* What `wait_for` of a future of C++ calls. */
#define AWAIT_FUTURE                                                                                 \
  _ZNSt28__atomic_futex_unsigned_base19_M_futex_wait_untilEPjjbNSt6chrono8durationIlSt5ratioILl1ELl1EEEENS2_IlS3_ILl1ELl1000000000EEEE
#define AWAIT_FUTURE_STEADILY                                                                        \
  _ZNSt28__atomic_futex_unsigned_base26_M_futex_wait_until_steadyEPjjbNSt6chrono8durationIlSt5ratioILl1ELl1EEEENS2_IlS3_ILl1ELl1000000000EEEE

EXPORT bool AWAIT_FUTURE(void *self, unsigned *at, unsigned value, bool ends, long s, long ns)
{
  WHILE(ends && begin_wait(__builtin_return_address(0)), end_wait);
  return BEHIND(AWAIT_FUTURE)(self, at, value, ends, s, ns);
}

EXPORT bool AWAIT_FUTURE_STEADILY(void *self, unsigned *at, unsigned value, bool ends, long s,
                                  long ns)
{
  WHILE(ends && begin_wait(__builtin_return_address(0)), end_wait);
  return BEHIND(AWAIT_FUTURE_STEADILY)(self, at, value, ends, s, ns);
}
