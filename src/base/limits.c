#include "base/limits.h"

#include <errno.h>

const char *limits_advice(int error, const char *otherwise)
{
	switch (error) {
	case EMFILE:
		return "raise the limit on open files (ulimit -n)";
	case ENFILE:
		return "close other programs: the machine has too many files open";
	case ENOMEM:
		return "free some memory, or raise the limit on it (ulimit -v)";
	case ENOSPC:
		return "free some disk space";
	case EDQUOT:
		return "free some space: the disk's quota is used up";
	case EFBIG:
		return "raise the limit on the size of files (ulimit -f)";
	case EROFS:
		return "mount its disk so that it can be written, or give another place";
	default:
		return otherwise;
	}
}
