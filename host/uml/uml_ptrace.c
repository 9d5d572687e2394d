/* uml_ptrace.c - preloaded into Debian's linux.uml, so that it starts on processors with a large extended state.
 *
 * The kernel of user-mode Linux 6.1 keeps the floating point registers of its processes in a buffer of 2696 bytes. On
 * processors whose state is larger (AMX) the host's kernel takes nothing but the whole of it: "ptrace set fp regs
 * failed, errno = 14". So whenever it sets a part, the whole is read first and the part is laid over it. Every other
 * request goes through as it is.
 */
#define _GNU_SOURCE

#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#define LARGEST_STATE 65536

static long call(long request, pid_t pid, void *address, void *data)
{
    return syscall(SYS_ptrace, request, pid, address, data);
}

static long set_extended_state(pid_t pid, void *address, struct iovec *part)
{
    static unsigned char state[LARGEST_STATE]; /* the kernel of user-mode Linux has one thread */
    struct iovec whole = {state, sizeof state};
    if (call(PTRACE_GETREGSET, pid, address, &whole) != 0 || whole.iov_len <= part->iov_len) {
        return call(PTRACE_SETREGSET, pid, address, part);
    }
    memcpy(state, part->iov_base, part->iov_len);
    return call(PTRACE_SETREGSET, pid, address, &whole);
}

/* The C library's own declaration has the request as an enum and arguments without a type. */
long ptrace(enum __ptrace_request request, ...)
{
    va_list arguments;
    long word = 0;
    va_start(arguments, request);
    const pid_t pid = va_arg(arguments, pid_t);
    void *const address = va_arg(arguments, void *);
    void *const data = va_arg(arguments, void *);
    va_end(arguments);
    switch (request) {
    case PTRACE_SETREGSET:
        if (address == (void *)NT_X86_XSTATE) {
            return set_extended_state(pid, address, data);
        }
        return call(request, pid, address, data);
    case PTRACE_PEEKTEXT:
    case PTRACE_PEEKDATA:
    case PTRACE_PEEKUSER: /* the system call stores the word, the function returns it */
        return (call(request, pid, address, &word) < 0) ? -1 : word;
    default:
        return call(request, pid, address, data);
    }
}
