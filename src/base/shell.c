#include "base/shell.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./+,:@%=-";

struct shell_text shell_path(const char *path)
{
	static const char quote[] = "'\\''"; /* closes the quotes, has a quote of its own, and opens them again */
	struct shell_text word;
	size_t used = 0;
	const size_t room = sizeof word.text - sizeof quote - 4;
	const bool quoted = path[0] == '\0' || path[0] == '-' || path[strspn(path, plain)] != '\0';
	if (path[0] == '-') { /* else it is taken for an option */
		memcpy(word.text, "./", 2);
		used = 2;
	}
	if (quoted)
		word.text[used++] = '\'';
	for (const char *c = path; *c != '\0' && used < room; c++)
		if (*c == '\'') {
			memcpy(word.text + used, quote, sizeof quote - 1);
			used += sizeof quote - 1;
		} else {
			word.text[used++] = *c;
		}
	if (quoted)
		word.text[used++] = '\'';
	word.text[used] = '\0';
	return word;
}
