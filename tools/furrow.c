/* furrow: the command. */
#include <stdio.h>
int main(void)
{
	puts("furrow " FURROW_VERSION);
	return 0;
}
