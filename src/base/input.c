#include "base/input.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NO_FILE ENOTBLK /* no call that is used here sets this errno: it means "no regular file" */

static int fail_mode(mode_t mode)
{
	return S_ISDIR(mode) ? EISDIR : NO_FILE;
}

FILE *input_open(const char *path)
{
	struct stat found;
	const int file = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
	int why = errno;
	if (file < 0) {
		errno = why == ENXIO ? NO_FILE : why; /* a socket */
		return NULL;
	}
	FILE *stream = NULL;
	if (fstat(file, &found) != 0)
		why = errno;
	else if (!S_ISREG(found.st_mode))
		why = fail_mode(found.st_mode);
	else if ((stream = fdopen(file, "rb")) == NULL)
		why = errno;
	if (stream != NULL)
		return stream;
	close(file);
	errno = why;
	return NULL;
}

bool input_is_file(const char *path)
{
	struct stat found;
	if (stat(path, &found) != 0)
		return false;
	if (!S_ISREG(found.st_mode))
		errno = fail_mode(found.st_mode);
	return S_ISREG(found.st_mode);
}

const char *input_problem(void)
{
	if (errno == NO_FILE)
		return "not a file";
	return errno == ELOOP ? "it is a link" : strerror(errno);
}

int output_create(const char *path, int flags)
{
	struct stat found;
	const int file = open(path, flags | O_CREAT | O_NOFOLLOW | O_NOCTTY | O_CLOEXEC, 0666);
	if (file >= 0 || errno != ELOOP)
		return file;
	const int device = open(path, (flags & ~(O_TRUNC | O_EXCL)) | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	if (device >= 0 && fstat(device, &found) == 0 && S_ISCHR(found.st_mode))
		return device;
	if (device >= 0)
		close(device);
	errno = ELOOP;
	return -1;
}

FILE *output_open(const char *path, const char *mode)
{
	struct stat found;
	const bool both = strchr(mode, '+') != NULL, end = mode[0] == 'a';
	const int file = output_create(path, (both ? O_RDWR : O_WRONLY) | (end ? O_APPEND : O_TRUNC) | O_NONBLOCK);
	if (file < 0) {
		errno = errno == ENXIO ? NO_FILE : errno; /* a pipe, or a socket */
		return NULL;
	}
	int why = NO_FILE;
	FILE *stream = NULL;
	if (fstat(file, &found) != 0)
		why = errno;
	else if ((S_ISREG(found.st_mode) || S_ISCHR(found.st_mode)) && (stream = fdopen(file, mode)) == NULL)
		why = errno;
	if (stream == NULL) {
		close(file);
		errno = why;
	}
	return stream;
}
