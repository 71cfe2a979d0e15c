/* A locale with a decimal comma for the whole process, made in the test's folder where the machine has none. */
#ifndef FURROW_TESTS_COMMA_H
#define FURROW_TESTS_COMMA_H

#include <locale.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

/* For a test's teardown, too. */
static inline int comma_end(void **state)
{
	return setlocale(LC_ALL, "C") == NULL;
}

/* Returns false if the locale cannot be made, as without Debian's package locales. */
static inline bool comma_begin(const char *folder)
{
	char command[300];
	snprintf(command, sizeof command, "test -d %s/de_DE.UTF-8 || localedef -f UTF-8 -i de_DE %s/de_DE.UTF-8 >/dev/null 2>&1", folder, folder);
	if (system(command) < 0)
		return false;
	setenv("LOCPATH", folder, 1);
	const bool made = setlocale(LC_ALL, "de_DE.UTF-8") != NULL;
	unsetenv("LOCPATH");
	return made && strtod("0,5", NULL) == 0.5;
}

#endif
