/* The locale "C", in which numbers have a decimal point. */
#ifndef FURROW_BASE_C_LOCALE_H
#define FURROW_BASE_C_LOCALE_H

#include <locale.h>

#include "base/status.h"

/*
 * *locale gets the locale "C", for uselocale. There is one for the whole process, and it is never freed. Nothing changes until a thread uses it.
 * STATUS_FAILED: it cannot be made; *locale is (locale_t)0, with which uselocale changes nothing. Any thread.
 */
enum status c_locale(locale_t *locale) FURROW_CHECKED;

#endif
