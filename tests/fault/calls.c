#include "calls.h"

#include <fcntl.h>
#include <stdarg.h>

/* Under both names: which one a call becomes is the C library's affair. */
int __wrap_open(const char *path, int flags, ...);
int __wrap_open64(const char *path, int flags, ...);
int __wrap_fsync(int file);
int __wrap_rename(const char *from, const char *to);
int __wrap_unlink(const char *path);
int __real_open(const char *path, int flags, ...);
int __real_fsync(int file);
int __real_rename(const char *from, const char *to);
int __real_unlink(const char *path);

static int real_open(const char *path, int flags, mode_t mode)
{
	return __real_open(path, flags, mode);
}

const struct calls calls_real = {real_open, __real_fsync, __real_rename, __real_unlink};
const struct calls *calls_now = &calls_real;

static mode_t mode_of(int flags, va_list arguments)
{
	return flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
}

int __wrap_open(const char *path, int flags, ...)
{
	va_list arguments;
	va_start(arguments, flags);
	mode_t mode = mode_of(flags, arguments);
	va_end(arguments);
	return calls_now->open(path, flags, mode);
}

int __wrap_open64(const char *path, int flags, ...)
{
	va_list arguments;
	va_start(arguments, flags);
	mode_t mode = mode_of(flags, arguments);
	va_end(arguments);
	return calls_now->open(path, flags, mode);
}

int __wrap_fsync(int file)
{
	return calls_now->fsync(file);
}

int __wrap_rename(const char *from, const char *to)
{
	return calls_now->rename(from, to);
}

int __wrap_unlink(const char *path)
{
	return calls_now->unlink(path);
}
