#include "base/c_locale.h"

#include <pthread.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static locale_t made;

static void make(void)
{
	made = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

enum status c_locale(locale_t *locale)
{
	pthread_once(&once, make);
	*locale = made;
	return made != (locale_t)0 ? STATUS_OK : fail_with(STATUS_FAILED, "locale C: it cannot be made; free some memory");
}
