/* LZ4 is not compiled with the sanitizers: what it is given is touched here, where it is checked. */
#include <lz4.h>

int __real_LZ4_decompress_safe(const char *from, char *to, int size, int room);
int __wrap_LZ4_decompress_safe(const char *from, char *to, int size, int room);

int __wrap_LZ4_decompress_safe(const char *from, char *to, int size, int room)
{
	static unsigned calls;
	volatile char touched;
	calls++;
	for (int i = 0; i < size; i++)
		touched = from[i];
	for (int i = 0; i < room; i++)
		to[i] = (char)((unsigned)i * 37 + calls); /* nobody may count on what was there */
	(void)touched;
	return __real_LZ4_decompress_safe(from, to, size, room);
}
