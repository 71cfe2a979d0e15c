#version 450 core
// Draws depth alone.
void main()
{
}
